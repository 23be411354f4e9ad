"""`tactus sweep`: python3 -m tactus.sweep OPTIONS, a JSON object of the program's."""
import json
import os
import shlex
import sys
import time

from .. import _core
from . import interrupts, local, plan, progress, results, units

BAD, INPUT, MACHINE = 1, 2, 3


class Sweep:
    def __init__(self, options):
        self.options = options
        self.program = options['program']
        self.identity = units.identity_of(self.program)
        self.plan = plan.read_plan(options['file'], self.identity, options.get('scenes', ''))
        folder = options['folder'] or os.path.splitext(os.path.basename(options['file']))[0] + '.sweep'
        self.results = results.Results(folder)
        self.run, self.retried, self.workers = 0, 0, 0
        self.began = time.monotonic()

    def list(self):
        """A command a line, for GNU parallel, xargs or an array of jobs."""
        more = ['--folder', self.results.folder] if self.options['folder'] else []
        for unit in self.plan.units:
            if not self.results.is_done(unit):
                print(shlex.join([self.program, 'sweep', self.options['file'], *more, '--unit', unit.name]))
        return 0

    def one(self, name):
        for unit in self.plan.units:
            if unit.name == name:
                if self.results.is_done(unit):
                    self.results.read(unit)  # says if it is damaged
                else:
                    self.results.prepare()
                    local.run_local(self.program, [unit], 1, self.take)
                return 0
        raise _core.OptionError(f'--unit: {name:.64} is no unit of this sweep by this program; accepted: those of --list')

    def all(self):
        if self.options['fresh']:
            self.results.forget(self.plan.units)
        waiting = [unit for unit in self.plan.units if not self.results.is_done(unit)]
        done_before = len(self.plan.units) - len(waiting)
        self.check_done()
        self.progress = progress.Progress(len(waiting))
        interrupted = False
        try:
            if waiting and not self.options['collect']:
                self.compute(waiting)
        except KeyboardInterrupt:
            interrupted = True
        self.progress.end()
        return self.report(done_before, interrupted)

    def check_done(self):
        """Before anything runs: results that are damaged, a line each."""
        damaged = []
        for unit in self.plan.units:
            try:
                if self.results.is_done(unit):
                    self.results.read(unit)
            except _core.FileError as error:
                damaged.append(str(error))
        if damaged:
            raise _core.FileError('\n'.join(damaged))

    def compute(self, waiting):
        self.results.prepare()
        if self.options['scheduler']:
            from . import cluster
            cluster.check_address(self.options['scheduler'], self.options['trust_network'])
            there = cluster.Cluster(self.options['scheduler'], self.program, self.identity,
                                    lambda line: print(f'tactus sweep: {line}', file=sys.stderr))
            try:
                there.run(waiting, self.take)
            finally:
                self.workers, self.retried = there.workers(), there.retried
            return
        self.workers = self.options['workers'] or len(os.sched_getaffinity(0))
        local.run_local(self.program, waiting, self.workers, self.take)

    def take(self, unit, result, retries):
        self.retried += retries
        self.results.write(unit, result)
        self.run += 1
        if hasattr(self, 'progress'):
            self.progress.advance()

    def write_table(self, option, content):
        path = self.options.get(option)
        if not path:
            return
        try:
            with open(path, 'wb') as file:
                file.write(content())
        except OSError as error:
            raise _core.MachineError(f'--{option} {path}: {error.strerror}') from None

    def report(self, done_before, interrupted):
        units_done = [unit for unit in self.plan.units if self.results.is_done(unit)]
        failed = [unit for unit in units_done if self.results.read(unit)['error']]
        missing = len(self.plan.units) - len(units_done)
        self.write_table('csv', lambda: results.table_of(self.plan, self.results).encode())
        self.write_table('hdf5', lambda: results.hdf5_of(self.plan, self.results))
        report = {'version': _core.__version__, 'units': len(self.plan.units), 'done_before': done_before,
                  'run': self.run, 'failed': len(failed), 'retried': self.retried, 'workers': self.workers,
                  'wall_s': time.monotonic() - self.began}
        if self.options['json']:
            print(json.dumps(report, indent=2))
        else:
            print(f'tactus sweep: {self.options["file"]} ({len(self.plan.units)} units)')
            print(f'  done before          {done_before}')
            print(f'  run                  {self.run}, {self.retried} again, by {self.workers} workers in '
                  f'{report["wall_s"]:.1f} s')
            print(f'  failed               {len(failed)}')
        for unit in failed[:5]:
            print(f'tactus sweep: {unit.name}: {self.results.read(unit)["error"]}', file=sys.stderr)
        if missing:
            why = 'interrupted' if interrupted else 'not all units are done'
            print(f'tactus sweep: {why}: {missing} of {len(self.plan.units)} are left; the same command goes on',
                  file=sys.stderr)
        return BAD if failed or missing else 0


def main():
    options = json.loads(sys.argv[1])
    interrupts.raise_once()
    try:
        sweep = Sweep(options)
        if options['list']:
            return sweep.list()
        return sweep.one(options['unit']) if options['unit'] else sweep.all()
    except KeyboardInterrupt:
        print('tactus sweep: interrupted', file=sys.stderr)
        return BAD
    except _core.Error as error:
        status = MACHINE if isinstance(error, _core.MachineError) else INPUT
        if options['json']:
            print(json.dumps({'version': _core.__version__, 'error': str(error), 'exit_code': status}, indent=2))
        print('tactus:', ''.join(c if c.isprintable() else '?' for c in str(error)), file=sys.stderr)
        return status


def run():
    """main(), whose reader may go away before the end, as that of `--list | head` does."""
    try:
        status = main()
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return BAD


sys.exit(run())
