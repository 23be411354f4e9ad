"""Units on this machine, a few processes at a time."""
import concurrent.futures

from . import units

MOST_RUNS = 3  # of a unit whose process a signal ends


def run_local(program, plan_units, workers, take):
    """Calls take(unit, result, retries) for each unit, as it ends. Ctrl-C leaves what is done, and ends the rest."""
    processes = set()
    stopping = False

    def started(process):
        processes.add(process)
        if stopping:
            process.kill()

    def run(unit):
        for attempt in range(MOST_RUNS):
            result = units.run_task(program, unit.task, started)
            if stopping or 'killed' not in result:
                break
        return result, attempt

    pool = concurrent.futures.ThreadPoolExecutor(workers)
    try:
        running = {pool.submit(run, unit): unit for unit in plan_units}
        for future in concurrent.futures.as_completed(running):
            take(running.pop(future), *future.result())
    except BaseException:
        stopping = True
        pool.shutdown(wait=False, cancel_futures=True)
        for process in list(processes):
            process.kill()
        raise
    finally:
        pool.shutdown()
