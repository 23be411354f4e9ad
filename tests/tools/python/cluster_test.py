#!/usr/bin/python3
"""tests/tools/python/cluster_test.py PROGRAM FOLDER: tactus sweep on a real scheduler with worker processes on this machine."""
import importlib.util
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time
import unittest

import bench
from long import long

if importlib.util.find_spec("distributed") is None:
    bench.skip("no Dask distributed (Debian: python3-distributed)")

PYTHON = "/usr/bin/python3"
SWEEP = """
scene = "press.toml"
duration_s = %g
seeds = %d
[keep]
summary = ["state_hash"]
columns = ["force_z_N:rms"]
"""


def free_port():
    with socket.socket() as sock:
        sock.bind(("127.0.0.1", 0))
        return sock.getsockname()[1]


class Cluster(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory(ignore_cleanup_errors=True)
        self.addCleanup(scratch.cleanup)
        self.scratch = scratch.name
        shutil.copy(bench.scene("press"), self.at("press.toml"))
        self.port, self.processes = free_port(), []
        self.addCleanup(self.end_all)
        self.address = f"tcp://127.0.0.1:{self.port}"

    def at(self, name):
        return os.path.join(self.scratch, name)

    def start(self, *command):
        environment = {**os.environ, "DASK_DISTRIBUTED__WORKER__DAEMON": "False"}
        process = subprocess.Popen(command, cwd=self.scratch, env=environment, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL, start_new_session=True)
        self.processes.append(process)
        return process

    def scheduler(self):
        return self.start(PYTHON, "-m", "distributed.cli.dask_scheduler", "--host", "127.0.0.1", "--port", str(self.port),
                          "--no-dashboard", "--pid-file", "")

    def worker(self, *options):
        return self.start(PYTHON, "-m", "distributed.cli.dask_worker", self.address, "--nthreads", "1", "--no-dashboard",
                          "--local-directory", self.at("work"), *options)

    def end_all(self):
        for process in self.processes:
            try:
                os.killpg(process.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
            process.wait()

    def write(self, seconds, units):
        with open(self.at("sweep.toml"), "w", encoding="utf-8") as file:
            file.write(SWEEP % (seconds, units))

    def begin(self, *arguments):
        return subprocess.Popen([bench.PROGRAM, "sweep", "sweep.toml", *arguments, "--json"], cwd=self.scratch,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def end(self, process, status=0):
        out, said = process.communicate(timeout=400)
        self.assertEqual(process.returncode, status, said.decode()[-2000:])
        return json.loads(out), said.decode()

    def wait_for_results(self, count):
        folder, until = self.at("sweep.sweep"), time.monotonic() + 120
        while time.monotonic() < until:
            if os.path.isdir(folder) and sum(name.endswith(".json") for name in os.listdir(folder)) >= count:
                return
            time.sleep(0.05)
        self.fail(f"no {count} results in 120 s")

    def read(self, name):
        with open(self.at(name), "rb") as file:
            return file.read()

    def expect_the_table_of_one_process(self, name):
        self.end(self.begin("--workers", "1", "--folder", "alone", "--csv", "alone.csv"))
        self.assertEqual(self.read(name), self.read("alone.csv"))

    def program(self, text):
        """A program in place of tactus, whose shell script ends with it."""
        path = self.at("tactus")
        with open(path, "w", encoding="utf-8") as file:
            file.write(f'#!/bin/sh\n{text}\nexec {bench.PROGRAM} "$@"\n')
        os.chmod(path, 0o755)
        return path

    def counting_program(self):
        """It writes a line for each run that it starts: the seed, and "again" where that unit's result is there already."""
        return self.program(f"""[ "$1" = run ] && {{
  seed=$(echo "$*" | sed 's/.*--seed \\([0-9]*\\).*/\\1/')
  again=$(grep -ls "\\"seed\\": $seed$" {self.at("sweep.sweep")}/*.json > /dev/null && echo again)
  echo "$seed $again" >> {self.at("started")}
}}""")

    def expect_no_unit_again_that_had_ended(self, units):
        with open(self.at("started"), encoding="utf-8") as file:
            lines = file.read().splitlines()
        self.assertEqual({int(line.split()[0]) for line in lines}, set(range(1, units + 1)))
        self.assertEqual([line for line in lines if "again" in line], [])
        print(f"{units} units: {len(lines)} runs were started")

    def read_until(self, process, words):
        """What the process says, up to and with the line that has these words; byte by byte, as nothing is buffered."""
        lines = [process.stderr.readline().decode()]
        while words not in lines[-1]:
            self.assertNotEqual(lines[-1], "", "".join(lines))  # the process has ended
            lines.append(process.stderr.readline().decode())
        return "".join(lines)

    def begin_by(self, program, **options):
        """The sweep by a program in place of tactus."""
        options = {"program": program, "file": "sweep.toml", "folder": "", "csv": self.at("cluster.csv"), "unit": "",
                   "workers": 0, "fresh": False, "list": False, "collect": False, "scheduler": self.address,
                   "trust_network": False, "json": True, **options}
        return subprocess.Popen([PYTHON, "-m", "tactus.sweep", json.dumps(options)], cwd=self.scratch,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE, bufsize=0,
                                env={**os.environ, "PYTHONPATH": bench.MODULE})

    def test_the_count_of_runs_sees_one_that_is_done_again(self):
        self.write(0.02, 2)
        program = self.counting_program()
        self.end(self.begin_by(program, scheduler="", workers=1))
        self.expect_no_unit_again_that_had_ended(2)
        subprocess.run([program, "run", self.at("press.toml"), "--virtual-time", "--duration", "0.01", "--seed", "2"],
                       check=True, stdout=subprocess.DEVNULL)
        with self.assertRaises(AssertionError):
            self.expect_no_unit_again_that_had_ended(2)

    @long
    def test_killed_and_stopped_workers_lose_no_unit(self):
        self.write(1.0, 20)
        self.scheduler()
        workers = [self.worker("--no-nanny") for _ in range(3)]
        sweep = self.begin_by(self.counting_program())
        self.wait_for_results(3)
        os.killpg(workers[0].pid, signal.SIGKILL)
        os.killpg(workers[1].pid, signal.SIGSTOP)
        time.sleep(30)
        os.killpg(workers[1].pid, signal.SIGCONT)
        report, _ = self.end(sweep)
        self.expect_no_unit_again_that_had_ended(20)
        self.assertEqual((report["units"], report["run"], report["failed"]), (20, 20, 0))
        self.expect_the_table_of_one_process("cluster.csv")

    @long
    def test_a_scheduler_that_was_killed_is_waited_for(self):
        self.write(1.0, 20)
        scheduler = self.scheduler()
        sweep = self.begin_by(self.counting_program())
        said = self.read_until(sweep, "waiting for a worker")
        self.assertIn("20 units left; accepted: dask-worker tcp://", said)
        for _ in range(3):
            self.worker()
        self.wait_for_results(3)
        os.killpg(scheduler.pid, signal.SIGKILL)
        scheduler.wait()
        self.scheduler()
        said += self.read_until(sweep, "the scheduler is gone")
        for _ in range(3):  # Debian's workers end with their scheduler
            self.worker()
        report, rest = self.end(sweep)
        said += rest
        for line in said.splitlines():
            self.assertTrue(line.startswith("tactus sweep: "), said)
        self.expect_no_unit_again_that_had_ended(20)
        self.assertEqual((report["run"], report["failed"]), (20, 0))  # each ended unit once
        self.expect_the_table_of_one_process("cluster.csv")

    @long
    def test_a_worker_of_another_build_is_turned_away(self):
        self.write(0.1, 12)
        self.scheduler()
        # The program says who it is by the worker's environment, as another build at the same path would.
        fake = self.program('[ "$1" = --version ] && [ -n "$OTHER_BUILD" ] && echo tactus 9.9.9 && exit 0')
        self.worker("--no-nanny", "--name", "same")
        os.environ["OTHER_BUILD"] = "yes"
        self.worker("--no-nanny", "--name", "other")
        del os.environ["OTHER_BUILD"]
        time.sleep(3)
        sweep = self.begin_by(fake)
        report, said = self.end(sweep)
        self.assertIn("worker other is turned away: it has tactus 9.9.9", said)
        self.assertEqual((report["run"], report["failed"], report["workers"]), (12, 0, 1))
        self.expect_the_table_of_one_process("cluster.csv")

    @long
    def test_an_experiment_there_has_the_figures_of_one_process(self):
        self.scheduler()
        for _ in range(2):
            self.worker()
        command = [bench.PROGRAM, "experiment", "energy-loss", "--scenes", "press,peg", "--quick", "--ratios", "8", "--json"]
        there, alone = ([*command, "--scheduler", self.address], command)
        said = [subprocess.run(one, cwd=self.scratch, check=True, stdout=subprocess.PIPE).stdout for one in (there, alone)]
        self.assertEqual(said[0], said[1])

    def test_no_scheduler_is_one_line(self):
        self.write(0.1, 1)
        report, said = self.end(self.begin("--scheduler", self.address), status=3)
        self.assertIn("no scheduler answers", report["error"])
        self.assertEqual(said.count("\n"), 1, said)

    @long
    def test_what_a_unit_costs_is_said(self):
        self.write(0.02, 60)
        self.scheduler()
        for _ in range(2):
            self.worker("--no-nanny")
        report, _ = self.end(self.begin("--scheduler", self.address))
        self.assertEqual(report["run"], 60)
        print(f"60 units on 2 workers: {report['wall_s'] / 60 * 1e3:.1f} ms each")


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=1)
