"""The parts of an experiment: python3 -m tactus.sweep.parts OPTIONS, a JSON object of the program's.

Prints each part's length (8 bytes, little end first) and bytes, in order; or a line with what went wrong, with exit
status 1, or 130 if it was interrupted. What is done is kept in this folder until all are, and not done again.
"""
import dataclasses
import hashlib
import json
import os
import shutil
import sys

from .. import _core
from . import interrupts, local, progress, results, units

INTERRUPTED = 130


@dataclasses.dataclass(frozen=True)
class Part:
    name: str
    task: tuple


class Parts:
    def __init__(self, options):
        self.options, self.program = options, options['program']
        self.identity = units.identity_of(self.program)
        content = json.dumps([options['arguments'], options['parts'], self.identity, *map(_content_of, options['scenes'])])
        self.folder = f'tactus-parts-{hashlib.sha256(content.encode()).hexdigest()[:16]}'
        self.parts = [Part(str(i), ('part', [*options['arguments'], '--part', str(i)])) for i in range(options['parts'])]

    def run(self):
        waiting = [part for part in self.parts if not os.path.exists(self._path(part))]
        self.progress = progress.Progress(len(waiting))
        try:
            if self.options['scheduler']:
                self._run_there(waiting)
            else:
                local.run_local(self.program, waiting, self.options['workers'], self._take)
        finally:
            self.progress.end()
        return [self._read(part) for part in self.parts]

    def forget(self):
        shutil.rmtree(self.folder, ignore_errors=True)

    def _run_there(self, waiting):
        from . import cluster
        cluster.check_address(self.options['scheduler'], self.options['trust_network'])
        there = cluster.Cluster(self.options['scheduler'], self.program, self.identity,
                                lambda line: print(f'tactus experiment: {line}', file=sys.stderr))
        there.run(waiting, self._take)

    def _take(self, part, result, retries):
        if result['error']:
            raise _core.Error(f'part {part.name}: {result["error"]}')
        results.write_whole(self._path(part), result['bytes'])
        self.progress.advance()

    def _path(self, part):
        return os.path.join(self.folder, part.name)

    def _read(self, part):
        with open(self._path(part), 'rb') as file:
            return file.read()


def _content_of(scene):
    """The hash of a scene, with the data of the files that it names: one that has changed is another experiment."""
    return hashlib.sha256(_core.CheckedScene.load(scene).text.encode()).hexdigest()


def main():
    interrupts.raise_once()
    kept = ''
    try:
        parts = Parts(json.loads(sys.argv[1]))
        kept = f'what is done is in {parts.folder}, and '
        for result in parts.run():
            sys.stdout.buffer.write(len(result).to_bytes(8, 'little') + result)
        sys.stdout.buffer.flush()
        parts.forget()
    except KeyboardInterrupt:
        print(f'interrupted; {kept}the same command goes on', end='')
        return INTERRUPTED
    except (_core.Error, OSError) as error:
        print(str(error).replace('\n', '; '), end='')
        return 1
    return 0


sys.exit(main())
