"""Units on a scheduler of Dask distributed (Debian: python3-distributed)."""
import ipaddress
import logging
import time
import urllib.parse

from .. import _core
from . import units

LOST_MOST = 3        # workers that a unit may lose before it is a row with that
IN_FLIGHT = 4        # units on their way, for each thread of a worker
LOOK_EVERY_S = 1.0   # for workers that came or went
SAY_EVERY_S = 30.0   # that there is none
RETURN_WITHIN_S = 120.0  # of a scheduler that is gone


def check_address(address, trust_network):
    """A scheduler runs the code of any client that can connect to it: loopback, TLS, or a network that the user answers for."""
    try:
        parts = urllib.parse.urlsplit(address)
        there = parts.scheme in ('tcp', 'tls') and parts.hostname and parts.port
    except ValueError:  # a port that is none, a bracket that is not closed
        there = False
    if not there:
        raise _core.OptionError(f'--scheduler: {address:.64} is no address; accepted: tcp://127.0.0.1:8786, tls://HOST:PORT')
    if parts.scheme == 'tls' or trust_network or _is_loopback(parts.hostname):
        return
    raise _core.OptionError(f'--scheduler: {address:.64}: a scheduler runs the code of any client that connects; accepted: '
                            'loopback, tls://, or --trust-network for a network that you trust')


def _is_loopback(host):
    try:
        return host == 'localhost' or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def _silence():
    """Of a connection that breaks, distributed and asyncio log tracebacks; what is of use, the sweep says itself."""
    for name in [*logging.root.manager.loggerDict, 'distributed', 'tornado', 'asyncio']:
        if name.split('.')[0] in ('distributed', 'tornado', 'asyncio'):
            logging.getLogger(name).setLevel(logging.CRITICAL + 1)


def run_there(program, identity, task):
    """On the worker: the result, and who ran it; nothing is run by another build."""
    there = units.identity_of(program)
    if there != identity:
        return {'other': there}
    return units.run_task(program, task)


def runs_lost(keys, dask_scheduler=None):
    """On the scheduler: how many times a worker died with one of these units."""
    return sum(dask_scheduler.tasks[key].suspicious for key in keys if key in dask_scheduler.tasks)


class Cluster:
    def __init__(self, address, program, identity, say):
        try:
            import cloudpickle
            import distributed
        except ImportError as error:
            raise _core.MachineError(f'--scheduler: {error} (Debian: python3-distributed)') from None
        # The worker needs nothing of ours but the program: these two modules go with the unit.
        import sys
        for module in (units, sys.modules[__name__]):
            cloudpickle.register_pickle_by_value(module)
        _silence()
        self.distributed, self.address, self.say = distributed, address, say
        self.program, self.identity = program, identity
        self.client, self.turned_away, self.seen, self.retried = None, {}, set(), 0
        self.lost_workers, self.waits_since, self.said = False, None, 0.0

    def run(self, waiting, take):
        """Calls take(unit, result, 0) for each unit, as it ends. A scheduler that went away is waited for."""
        left = {unit.name: unit for unit in waiting}
        self._connect(10.0)
        while left:
            try:
                self._run(left, take)
            except (OSError, self.distributed.CancelledError, self.distributed.comm.CommClosedError) as error:
                self.say(f'the scheduler is gone ({type(error).__name__}); waiting for it')
                self._close()
                self._connect(RETURN_WITHIN_S)
        self._close()

    def workers(self):
        return len(self.seen - set(self.turned_away))

    def _connect(self, within_s):
        until = time.monotonic() + within_s
        while True:
            try:
                self.client = self.distributed.Client(self.address, timeout='5s')
                return
            except (OSError, TimeoutError) as error:
                if time.monotonic() > until:
                    raise _core.MachineError(f'--scheduler: {self.address}: no scheduler answers ({error!s:.80}); '
                                             'accepted: the address that dask-scheduler prints') from None
                time.sleep(0.5)

    def _close(self):
        try:
            self.client.close(timeout=2)
        except Exception:  # of a connection that is gone
            pass

    def _look_at_workers(self):
        """Asks new workers who they are; names those that are turned away. The addresses of the good ones."""
        info = self.client.scheduler_info()['workers']
        new = [address for address in info if address not in self.seen]
        for address, identity in (self.client.run(units.identity_of, self.program, workers=new) if new else {}).items():
            self.seen.add(address)
            if identity != self.identity:
                self.turned_away[address] = identity
                self.say(f'worker {info[address].get("name", address)} is turned away: it has {identity}; accepted: '
                         f'{self.identity}')
        self.lost_workers = self.lost_workers or any(address not in info for address in self.seen)
        good = [address for address in info if address not in self.turned_away]
        return good, sum(info[address]['nthreads'] for address in good)

    def _run(self, left, take):
        running, lost, looked, good, threads = {}, {}, 0.0, None, 0
        while left:
            if time.monotonic() - looked > LOOK_EVERY_S:
                looked = time.monotonic()
                before, (good, threads) = good, self._look_at_workers()
                if self.turned_away and before is not None and before != good:
                    for future in running:  # where they may run has changed
                        future.cancel()
                    running.clear()
            self._say_if_it_waits(good, len(left))
            self._fill(left, running, good, threads)
            if not running:
                time.sleep(LOOK_EVERY_S / 4)
                continue
            self._take_done(left, running, lost, take)

    def _say_if_it_waits(self, good, count):
        """That there is no worker, at once and then every SAY_EVERY_S."""
        now = time.monotonic()
        if good:
            self.waits_since = None
        elif self.waits_since is None or now - self.said > SAY_EVERY_S:
            self.said, self.waits_since = now, self.waits_since or now
            self.say(f'waiting for a worker{" of this build" if self.turned_away else ""}, {now - self.waits_since:.0f} s, '
                     f'{count} units left; accepted: dask-worker {self.address}')

    def _fill(self, left, running, good, threads):
        on_the_way = set(running.values())
        where = {'workers': good, 'allow_other_workers': False} if self.turned_away else {}
        for name, unit in left.items():
            if len(running) >= IN_FLIGHT * threads:
                break
            if name in on_the_way:
                continue
            future = self.client.submit(run_there, self.program, self.identity, unit.task, pure=False, **where)
            running[future] = name

    def _take_done(self, left, running, lost, take):
        try:
            done = self.distributed.wait(list(running), timeout=LOOK_EVERY_S, return_when='FIRST_COMPLETED').done
        except (TimeoutError, self.distributed.TimeoutError):
            if self.client.status not in ('running', 'newly-created'):
                raise OSError(f'client {self.client.status}') from None
            return
        if self.lost_workers:
            self.retried += self.client.run_on_scheduler(runs_lost, [future.key for future in done])
        for future in done:
            name = running.pop(future)
            if future.status == 'cancelled':
                raise self.distributed.CancelledError(name)
            error = future.exception()
            result = future.result() if error is None else {'error': f'{type(error).__name__}: {error}', 'figures': {}}
            if isinstance(error, self.distributed.scheduler.KilledWorker):
                result['error'] = 'its worker died each time'
            if 'other' in result:
                continue  # a worker that came a moment ago: it is asked who it is
            if 'killed' in result and lost.setdefault(name, 0) < LOST_MOST - 1:
                lost[name] += 1
                self.retried += 1
                continue
            take(left.pop(name), result, 0)
