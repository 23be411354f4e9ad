#!/usr/bin/python3
"""tests/tools/python/sweep_test.py PROGRAM FOLDER: tactus sweep on this machine: the table does not depend on who ran what."""
import csv
import glob
import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import bench
from long import long

GAINS = os.path.join(bench.SOURCE, "tools", "examples", "gains.toml")
SMALL = """
scene = "press.toml"
duration_s = 0.02
seeds = %d
[keep]
summary = ["state_hash", "hand/force_max_N"]
columns = ["force_z_N:rms", "proxy_position_z_m:last"]
"""
HAND = """time_s,position_x_m,position_y_m,position_z_m
0,0,0,0.2155
1,0,0,0.2075
"""


class Sweeps(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.scratch = scratch.name
        shutil.copy(bench.scene("press"), self.at("press.toml"))

    def at(self, name):
        return os.path.join(self.scratch, name)

    def write(self, name, text):
        with open(self.at(name), "w", encoding="utf-8") as file:
            file.write(text)
        return self.at(name)

    def sweep(self, *arguments, status=0):
        done = subprocess.run([bench.PROGRAM, "sweep", *map(str, arguments), "--json"], cwd=self.scratch, check=False,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, status, done.stderr)
        return json.loads(done.stdout)

    def read(self, name):
        with open(self.at(name), "rb") as file:
            return file.read()

    def test_the_table_is_the_same_for_any_number_of_workers(self):
        first = self.sweep(GAINS, "--workers", 1, "--csv", "one.csv")
        self.assertEqual((first["units"], first["done_before"], first["run"], first["failed"]), (12, 0, 12, 0))
        again = self.sweep(GAINS, "--workers", 3, "--csv", "again.csv")
        self.assertEqual((again["done_before"], again["run"]), (12, 0))
        other = self.sweep(GAINS, "--workers", 3, "--folder", "other", "--csv", "three.csv")
        self.assertEqual((other["run"], other["workers"]), (12, 3))
        fresh = self.sweep(GAINS, "--workers", 2, "--fresh", "--csv", "fresh.csv")
        self.assertEqual((fresh["done_before"], fresh["run"]), (0, 12))
        for name in ("again.csv", "three.csv", "fresh.csv"):
            self.assertEqual(self.read(name), self.read("one.csv"))

    def test_a_row_has_the_figures_of_its_run(self):
        self.sweep(GAINS, "--csv", "gains.csv")
        with open(self.at("gains.csv"), newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        self.assertEqual(len(rows), 12)
        row = next(row for row in rows if row["coupling"] == "static" and row["ratio"] == "5" and
                   row["coupling.stiffness_N_per_m"] == "1500.0")
        run = bench.run("press", 1, "--coupling", "static", "--ratio", 5, "--figures", "force_z_N:rms")
        self.assertEqual(row["state_hash"], run["state_hash"])
        self.assertEqual(float(row["hand/force_max_N"]), run["hand"]["force_max_N"])
        self.assertEqual(float(row["force_z_N:rms"]), run["figures"]["force_z_N:rms"])
        self.assertEqual(len({row["state_hash"] for row in rows}), 12)

    def test_list_and_collect(self):
        sweep = self.write("small.toml", SMALL % 4)
        listed = subprocess.run([bench.PROGRAM, "sweep", sweep, "--list"], cwd=self.scratch, check=True,
                                stdout=subprocess.PIPE, text=True).stdout.splitlines()
        self.assertEqual(len(listed), 4)
        subprocess.run(listed[2], shell=True, check=True, cwd=self.scratch)
        part = self.sweep(sweep, "--collect", "--csv", "part.csv", status=1)
        self.assertEqual((part["units"], part["done_before"], part["run"]), (4, 1, 0))
        self.assertEqual(self.read("part.csv").count(b"\n"), 2)
        for command in listed:
            subprocess.run(command, shell=True, check=True, cwd=self.scratch)
        self.sweep(sweep, "--collect", "--csv", "listed.csv")
        self.sweep(sweep, "--folder", "other", "--csv", "direct.csv")
        self.assertEqual(self.read("listed.csv"), self.read("direct.csv"))
        self.assertIn("excludes", self.sweep(sweep, "--collect", "--fresh", status=2)["error"])
        self.assertEqual(self.sweep(sweep)["done_before"], 4)

    def list_with_spaces(self):
        sweep = self.write("my small $sweep.toml", SMALL % 3)
        listed = subprocess.run([bench.PROGRAM, "sweep", sweep, "--folder", "a folder", "--list"], cwd=self.scratch, check=True,
                                stdout=subprocess.PIPE, text=True).stdout
        self.assertEqual(listed.count("\n"), 3)
        return sweep, listed

    def expect_the_listed_units(self, sweep):
        report = self.sweep(sweep, "--folder", "a folder", "--collect", "--csv", "listed.csv")
        self.assertEqual((report["done_before"], report["failed"]), (3, 0))
        self.sweep(sweep, "--folder", "other", "--csv", "direct.csv")
        self.assertEqual(self.read("listed.csv"), self.read("direct.csv"))

    @long
    def test_gnu_parallel_runs_a_list_with_names_of_spaces(self):
        if not shutil.which("parallel"):
            self.skipTest("no GNU parallel (Debian: parallel)")
        sweep, listed = self.list_with_spaces()
        subprocess.run(["parallel", "--will-cite"], input=listed, text=True, check=True, cwd=self.scratch,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.expect_the_listed_units(sweep)

    @long
    def test_a_slurm_array_runs_a_list(self):
        sweep, listed = self.list_with_spaces()
        self.write("units.txt", listed)
        for task in (3, 1, 2):  # as Slurm starts the script
            subprocess.run(["/bin/bash", os.path.join(bench.SOURCE, "tools", "examples", "slurm_array.sh"), "units.txt"],
                           env={**os.environ, "SLURM_ARRAY_TASK_ID": str(task)}, cwd=self.scratch, check=True)
        self.expect_the_listed_units(sweep)

    def test_the_reader_of_a_list_may_go_away(self):
        sweep = self.write("small.toml", SMALL % 2000)
        process = subprocess.Popen([bench.PROGRAM, "sweep", sweep, "--list"], cwd=self.scratch, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE)
        self.assertIn(b"--unit", process.stdout.readline())
        process.stdout.close()
        self.assertEqual(process.stderr.read(), b"")
        process.stderr.close()
        process.wait()

    @long
    def test_a_sweep_far_from_the_scenes_has_those_of_tactus(self):
        os.mkdir(self.at("far"))
        shutil.copy(GAINS, self.at("far"))
        report = self.sweep(os.path.join("far", "gains.toml"), "--csv", "far.csv")
        self.assertEqual((report["run"], report["failed"]), (12, 0))
        self.assertIn("nowhere.toml", self.sweep(self.write("none.toml", "scene='nowhere.toml'\n[keep]\nsummary=['a']"),
                                                 status=2)["error"])

    def test_keys_of_a_list_count_from_one(self):
        text = (SMALL % 1).replace("press", "two") + "[keys]\n'body.%s.mass_kg' = [0.5, 2]\n"
        self.write("two.toml", self.read("press.toml").decode() + """
[[body]]
shape = "box"
size_m = [0.1, 0.1, 0.1]
mass_kg = 1
position_m = [1, 0, 1]
""")
        bodies = self.read("two.toml").count(b"[[body]]")
        for number in ("0", "-1", "+1", " 1", "1.0", "x", str(bodies + 1), "99999999999"):
            with self.subTest(number=number):
                said = self.sweep(self.write("wrong.toml", text % number), status=2)["error"]
                self.assertIn("N from 1", said)
        report = self.sweep(self.write("right.toml", text % bodies), "--csv", "right.csv")
        self.assertEqual((report["run"], report["failed"]), (2, 0))

    @long
    def test_the_table_as_hdf5(self):
        try:
            import h5py
        except ImportError:
            self.skipTest("no h5py (Debian: python3-h5py)")
        sweep = self.write("fails.toml", SMALL % 2 + '[options]\nrate_Hz = [1000, 20]\ncoupling = ["sub-world"]\n')
        self.sweep(sweep, "--workers", 1, "--csv", "one.csv", "--hdf5", "one.h5", status=1)
        self.sweep(sweep, "--workers", 3, "--folder", "other", "--hdf5", "three.h5", status=1)
        self.assertEqual(self.read("one.h5"), self.read("three.h5"))
        with open(self.at("one.csv"), newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        with h5py.File(self.at("one.h5")) as file:
            table = file["units"][:]
            self.assertEqual(list(table.dtype.names), list(rows[0]))
            self.assertEqual(str(table.dtype["rate_Hz"]), "int64")
            self.assertEqual(str(table.dtype["hand/force_max_N"]), "float64")
        for row, record in zip(rows, table, strict=True):
            for name, text in row.items():
                value = record[name]
                if isinstance(value, bytes):
                    self.assertEqual(value.decode(), text)
                else:
                    self.assertEqual(repr(value.item()), text or "nan")

    def test_damaged_results_are_said_before_anything_runs(self):
        sweep = self.write("small.toml", SMALL % 4)
        self.sweep(sweep)
        whole = sorted(glob.glob(self.at("small.sweep/*.json")))
        for path, content in zip(whole, (b"", b"{}", b"\xff\xfe" + b"[" * 30000)):
            with open(path, "wb") as file:
                file.write(content)
        for options in ([], ["--collect"], ["--collect", "--csv", "a.csv"]):
            lines = self.sweep(sweep, *options, status=2)["error"].splitlines()
            self.assertEqual(len(lines), 3)
            for line in lines:
                self.assertRegex(line, r"^small\.sweep/[0-9a-f]+\.json: is damaged; accepted: ")
        name = os.path.splitext(os.path.basename(whole[0]))[0]
        self.assertIn("is damaged", self.sweep_unit(sweep, name))
        self.assertEqual(self.sweep(sweep, "--fresh")["run"], 4)

    def sweep_unit(self, sweep, name):
        done = subprocess.run([bench.PROGRAM, "sweep", sweep, "--unit", name], cwd=self.scratch, check=False,
                              stderr=subprocess.PIPE, text=True)
        self.assertEqual((done.returncode, done.stderr.count("\n")), (2, 1), done.stderr)
        return done.stderr

    def test_folders_that_cannot_be_are_lines(self):
        sweep = self.write("small.toml", SMALL % 1)
        for folder in ("/etc/passwd", "/proc/nowhere", "small.toml/below"):
            with self.subTest(folder=folder):
                self.assertRegex(self.sweep(sweep, "--folder", folder, status=2)["error"], f"^--folder {folder}: .*; accepted: ")

    def test_a_unit_that_fails_is_a_row_and_the_rest_goes_on(self):
        sweep = self.write("fails.toml", SMALL % 1 + '[options]\nrate_Hz = [1000, 20]\n')
        report = self.sweep(sweep, "--csv", "fails.csv", status=1)
        self.assertEqual((report["units"], report["run"], report["failed"]), (2, 2, 1))
        with open(self.at("fails.csv"), newline="", encoding="utf-8") as file:
            good, bad = csv.DictReader(file)
        self.assertEqual((good["rate_Hz"], good["error"]), ("1000", ""))
        self.assertIn("--rate", bad["error"])
        self.assertEqual(bad["state_hash"], "")

    def test_a_unit_whose_process_is_killed_runs_again(self):
        once = self.at("once")
        fake = self.write("tactus", f"""#!/bin/sh
[ "$1" = run ] && [ ! -e {once} ] && touch {once} && kill -9 $$
exec {bench.PROGRAM} "$@"
""")
        os.chmod(fake, 0o755)
        sweep = self.write("small.toml", SMALL % 2)
        options = {"program": fake, "file": sweep, "folder": "", "csv": self.at("killed.csv"), "unit": "", "workers": 1,
                   "fresh": False, "list": False, "collect": False, "scheduler": "", "trust_network": False, "json": True}
        done = subprocess.run(["/usr/bin/python3", "-m", "tactus.sweep", json.dumps(options)], cwd=self.scratch, check=True,
                              stdout=subprocess.PIPE, env={**os.environ, "PYTHONPATH": bench.MODULE})
        report = json.loads(done.stdout)
        self.assertEqual((report["run"], report["retried"], report["failed"]), (2, 1, 0))
        self.sweep(sweep, "--folder", "other", "--csv", "direct.csv")
        self.assertEqual(self.read("killed.csv"), self.read("direct.csv"))

    @long
    def test_ctrl_c_leaves_what_is_done_and_the_same_command_goes_on(self):
        sweep = self.write("long.toml", (SMALL % 30).replace("0.02", "0.5"))
        process = subprocess.Popen([bench.PROGRAM, "sweep", sweep, "--workers", "2", "--json"], cwd=self.scratch,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        folder = self.at("long.sweep")
        until = time.monotonic() + 60
        while len(glob.glob(os.path.join(folder, "*.json"))) < 3 and time.monotonic() < until:
            time.sleep(0.02)
        process.send_signal(signal.SIGINT)
        out, said = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1)
        self.assertIn(b"the same command goes on", said)
        done = json.loads(out)["run"]
        self.assertTrue(3 <= done < 30, done)
        files = os.listdir(folder)
        self.assertEqual((len(files), [name for name in files if name.endswith(".part")]), (done, []))
        report = self.sweep(sweep, "--csv", "resumed.csv")
        self.assertEqual((report["done_before"], report["run"]), (done, 30 - done))

    def experiment(self, *arguments, status=0):
        done = subprocess.run([bench.PROGRAM, "experiment", *map(str, arguments)], cwd=self.scratch, check=False,
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.assertEqual(done.returncode, status, done.stderr)
        return done

    @long
    def test_an_experiment_by_workers_has_the_figures_of_one_process(self):
        shutil.copy(bench.scene("card_house"), self.at("cards.toml"))
        whole = ("--seeds", 0, "--whole", 1, "--scene", "press.toml", "--scene", "cards.toml", "--members", "8,16",
                 "--ratios", 8, "--borders", "ghost")
        for command in (("couplings", "--scenes", "press,peg", "--quick", "--ratios", 16), ("energy-loss", *whole),
                        ("hard-cases", "--random", 11, "--first", 3, "--sub-world"),
                        ("hard-cases", "--random", 11, "--first", 5)):
            with self.subTest(command=" ".join(map(str, command))):
                alone = self.experiment(*command, "--json").stdout
                spread = self.experiment(*command, "--json", "--workers", 3).stdout
                self.assertEqual(json.loads(spread), json.loads(alone))
        self.assertEqual(glob.glob(self.at("tactus-parts-*")), [])

    @long
    def test_accuracy_cost_by_workers_has_the_errors_of_one_process(self):
        command = ("accuracy-cost", "--quick", "--scenes", "press", "--seeds", 2, "--json")
        reports = [json.loads(self.experiment(*command, *more).stdout) for more in ((), ("--workers", 2))]
        errors = [[{key: value for key, value in point.items() if "_us" not in key and key not in ("on_front", "instructions")}
                   for point in report["points"]] for report in reports]
        self.assertGreater(len(errors[0]), 5)
        self.assertTrue(all(len(point["force_error_by_seed"]) == 2 for point in errors[0]))
        self.assertEqual(errors[0], errors[1])

    def test_a_part_that_fails_or_is_interrupted_is_said(self):
        said = self.experiment("energy-loss", "--quick", "--part", 99, "--json", status=2)
        self.assertIn("--part: accepted: 0 to", json.loads(said.stdout)["error"])
        said = self.experiment("energy-loss", "--quick", "--scheduler", "tcp://10.0.0.1:8786", "--json", status=2)
        self.assertIn("--trust-network", json.loads(said.stdout)["error"])
        said = self.experiment("hard-cases", "--workers", 2, "--json", status=2)
        self.assertIn("--random N", json.loads(said.stdout)["error"])

    def workers(self, seed):
        """The processes of parts of an experiment on random worlds from this seed on."""
        found = []
        for path in glob.glob("/proc/[0-9]*/cmdline"):
            try:
                with open(path, "rb") as file:
                    words = file.read().split(b"\0")
            except OSError:
                continue
            if b"--part" in words and str(seed).encode() in words:
                found.append(path)
        return found

    def test_an_interrupted_experiment_ends_its_workers_and_goes_on_later(self):
        for seed, end in ((7001, lambda process: os.killpg(process.pid, signal.SIGINT)),  # a terminal's Ctrl-C
                          (7002, lambda process: process.send_signal(signal.SIGINT)),
                          (7003, lambda process: process.send_signal(signal.SIGTERM)),
                          (7004, lambda process: process.send_signal(signal.SIGHUP))):
            with self.subTest(seed=seed):
                command = [bench.PROGRAM, "experiment", "hard-cases", "--random", "2000", "--first", str(seed), "--workers", "2"]
                process = subprocess.Popen(command, cwd=self.scratch, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                           start_new_session=True)
                until = time.monotonic() + 60
                while not (glob.glob(self.at("tactus-parts-*/[0-9]*")) and self.workers(seed)) and time.monotonic() < until:
                    time.sleep(0.02)
                end(process)
                _, text = process.communicate(timeout=60)
                self.assertEqual(process.returncode, 1)
                self.assertEqual(self.workers(seed), [])
                self.assertRegex(text, b"^tactus experiment hard-cases: interrupted; what is done is in tactus-parts-[0-9a-f]*, "
                                       b"and the same command goes on\n$")
                self.assertTrue(glob.glob(self.at("tactus-parts-*/[0-9]*")))
                shutil.rmtree(glob.glob(self.at("tactus-parts-*"))[0])

    def test_a_killed_experiment_leaves_no_workers(self):
        process = subprocess.Popen([bench.PROGRAM, "experiment", "hard-cases", "--random", "2000", "--first", "7005",
                                    "--workers", "2"], cwd=self.scratch, stderr=subprocess.DEVNULL)
        until = time.monotonic() + 60
        while not self.workers(7005) and time.monotonic() < until:
            time.sleep(0.02)
        process.kill()
        process.wait()
        while self.workers(7005) and time.monotonic() < until:
            time.sleep(0.02)
        self.assertEqual(self.workers(7005), [])

    def write_scene_of_files(self):
        """A scene that names a hull's file, a mesh's and the hand's. Returns their names."""
        with open(bench.scene("press"), encoding="utf-8") as file:
            text = file.read()
        self.write("files.toml", text[:text.index("[hand]")] + """
[[body]]
shape = "hull"
file = "stone.obj"
mass_kg = 0.1
position_m = [1, 0, 0]

[[body]]
shape = "mesh"
file = "ramp.obj"
position_m = [-2, 0, 0]

[hand]
file = "hand.csv"
""")
        self.write("stone.obj", "v 0 0 0\nv 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
        self.write("ramp.obj", "v 0 0 0\nv 0.5 0 0\nv 0 0.5 0.1\nf 1 2 3\n")
        self.write("hand.csv", HAND)
        return {"stone.obj": ("0 0 0.1", "0 0 0.12"), "ramp.obj": ("0.5 0.1", "0.5 0.2"), "hand.csv": ("0.2075", "0.2070")}

    def edit(self, name, old, new):
        text = self.read(name).decode()
        self.assertEqual(text.count(old), 1)
        self.write(name, text.replace(old, new))

    def parts_folders(self, scene):
        """The folders that are there after the parts of this scene ran, of which one fails, so that they stay."""
        fake = self.write("tactus", """#!/bin/sh
case "$*" in *--version*) echo fake;; *"--part 1") exit 2;; *) printf x;; esac
""")
        os.chmod(fake, 0o755)
        options = json.dumps({"program": fake, "arguments": ["experiment", "energy-loss"], "parts": 2, "scenes": [self.at(scene)],
                              "workers": 1, "scheduler": "", "trust_network": False})
        done = subprocess.run(["/usr/bin/python3", "-m", "tactus.sweep.parts", options], cwd=self.scratch, check=False,
                              stdout=subprocess.PIPE, env={**os.environ, "PYTHONPATH": bench.MODULE})
        self.assertEqual((done.returncode, done.stdout), (1, b"part 1: exit status 2"))
        return glob.glob(self.at("tactus-parts-*/0"))

    def test_a_scene_that_has_changed_is_another_experiment(self):
        self.assertEqual(len(self.parts_folders("press.toml")), 1)
        self.assertEqual(len(self.parts_folders("press.toml")), 1)
        self.edit("press.toml", "mass_kg = 100", "mass_kg = 101")
        self.assertEqual(len(self.parts_folders("press.toml")), 2)

    def test_a_file_that_a_scene_names_has_changed(self):
        files = self.write_scene_of_files()
        sweep = self.write("files_sweep.toml", (SMALL % 1).replace("press.toml", "files.toml"))
        self.assertEqual(self.sweep(sweep)["run"], 1)
        self.assertEqual(self.sweep(sweep)["done_before"], 1)
        self.assertEqual(len(self.parts_folders("files.toml")), 1)
        for folders, (name, (old, new)) in enumerate(files.items(), 2):
            with self.subTest(file=name):
                self.edit(name, old, new)
                self.assertEqual(len(self.parts_folders("files.toml")), folders)
                report = self.sweep(sweep)
                self.assertEqual((report["done_before"], report["run"], report["failed"]), (0, 1, 0))

    def test_mistakes_are_lines(self):
        for text, said in (("scene = 'nowhere.toml'\n[keep]\nsummary = ['a']", "nowhere.toml"),
                           (SMALL % 1 + "[option]\na = 1", "option: no such key"),
                           (SMALL % 1 + "[options]\ncouplin = 1", "[options] couplin"),
                           (SMALL % 1 + "[keys]\n'proxy.mass_kg' = -1", "mass_kg"),
                           (SMALL % 1 + "[keys]\n'nothing.here' = 1", "[keys] nothing.here"),
                           (SMALL % 1 + "[keys]\n'proxy.mass_kg' = {from = 1}", "{from = A, to = B, steps = N}"),
                           ("scene = 'press.toml'", "nothing is kept"), ("scene =", "accepted: a sweep file"),
                           ("a = " + "[" * 20000, "nested too deeply"), ("a = " + "[" * 400 + "]" * 400, "a: no such key"),
                           (SMALL % 1 + "[keys]\na = " + "[" * 400 + "]" * 400, "nested too deeply"),
                           (SMALL % 1 + "[keys]\na = [[[{b = 1}]]]", "accepted: a value"),
                           (SMALL % 1 + "[keys]\na = [1979-05-27]", "accepted: a value"),
                           (SMALL % 1 + "[keys]\n'proxy.mass_kg' = [1, 2, 1]", "1 twice; accepted: each value once"),
                           (SMALL % 1 + "[keys]\n'a' = {from = 0, to = 1, steps = 100000000}", "2 to 100000 steps"),
                           (SMALL % 1 + "[keys]\n'a' = {from = 0, to = 1%s, steps = 2}" % ("0" * 400), "two numbers"),
                           (SMALL.replace("%d", "[1, 1]"), "seeds: 1 twice"), (SMALL.replace("%d", "[true]"), "seeds: [True]"),
                           (SMALL % 100000000, "seeds: 100000000; accepted: their number, 1 to 100000"),
                           (SMALL.replace("%d", "'many'"), "seeds: many")):
            with self.subTest(said=said):
                report = self.sweep(self.write("wrong.toml", text), status=2)
                self.assertIn(said, report["error"])
        with open(self.at("wrong.toml"), "wb") as file:
            file.write(b"scene = '\xff'\n")
        self.assertIn("can't decode", self.sweep("wrong.toml", status=2)["error"])
        sweep = self.write("small.toml", SMALL % 1)
        self.assertIn("is no unit", self.sweep(sweep, "--unit", "abc", status=2)["error"])
        self.assertIn("--trust-network", self.sweep(sweep, "--scheduler", "tcp://10.0.0.1:8786", status=2)["error"])
        for address in ("tcp://localhost", "tcp://localhost:x", "tcp://localhost:99999", "tcp://[::1", "localhost:8786", "tcp://"):
            self.assertIn("is no address", self.sweep(sweep, "--scheduler", address, status=2)["error"])

    @long
    def test_what_a_unit_costs_beyond_its_run(self):
        sweep = self.write("small.toml", SMALL % 40)
        report = self.sweep(sweep, "--workers", 1)
        began = time.monotonic()
        for seed in range(40):
            bench.program("run", self.at("press.toml"), "--virtual-time", "--duration", 0.02, "--seed", seed, "--figures",
                          "force_z_N:rms")
        alone_s = time.monotonic() - began
        print(f"40 units: {report['wall_s'] / 40 * 1e3:.1f} ms each, the runs alone {alone_s / 40 * 1e3:.1f} ms")
        self.assertEqual(report["run"], 40)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=1)
