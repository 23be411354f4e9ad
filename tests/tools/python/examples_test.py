#!/usr/bin/python3
"""tests/tools/python/examples_test.py PROGRAM FOLDER: the examples of Python run, and their figures are what they must be."""
import csv
import os
import re
import subprocess
import sys
import tempfile
import unittest

import bench
import tactus
from long import long

EXAMPLES = os.path.join(bench.SOURCE, "tools", "examples")


def example(name, *arguments, check=True, **options):
    environment = {"PATH": os.path.dirname(bench.PROGRAM) + ":/usr/bin:/bin", "PYTHONPATH": bench.MODULE}
    return subprocess.run(["/usr/bin/python3", "-B", os.path.join(EXAMPLES, name), *map(str, arguments)], check=check,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment, **options)


class Examples(unittest.TestCase):
    def setUp(self):
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.scratch = scratch.name

    def at(self, name):
        return os.path.join(self.scratch, name)

    def test_tape_to_plot(self):
        try:
            import matplotlib  # noqa: F401
        except ImportError:
            self.skipTest("no matplotlib (Debian: python3-matplotlib)")
        bench.run("press", 1, "--record", self.at("a.tape"))
        out = example("tape_to_plot.py", self.at("a.tape"), "-o", self.at("a.svg")).stdout
        self.assertIn("1000 ticks", out)
        with open(self.at("a.svg"), encoding="utf-8") as file:
            self.assertIn("</svg>", file.read())
        bad = example("tape_to_plot.py", self.at("a.svg"), check=False)
        self.assertEqual((bad.returncode, bad.stderr.count("\n")), (1, 1))

    def test_gain_swept(self):
        lines = example("gain_swept.py", bench.scene("press"), "--gains", 500, 1000, "--seconds", 1).stdout.splitlines()
        rows = [list(map(float, line.split())) for line in lines[1:]]
        self.assertEqual([row[0] for row in rows], [500, 1000])
        session = tactus.Session(bench.scene("press"))
        session.step(1000)
        self.assertGreater(rows[1][2], rows[0][2])  # a stiffer coupling presses harder
        bad = example("gain_swept.py", bench.scene("press"), "--gains", 1e7, check=False)
        self.assertEqual((bad.returncode, bad.stderr.count("\n")), (1, 1))

    def test_circle_hand(self):
        out = example("circle_hand.py", "--force", 2, "--radius", 0.03, "--record", self.at("circle.tape")).stdout
        angle, radius_mm, radius_error_mm, force, force_error = map(float, re.findall(r"-?\d+\.\d+", out))
        self.assertAlmostEqual(angle, 360, delta=10)
        self.assertAlmostEqual(radius_mm, 30, delta=2)
        self.assertLess(radius_error_mm, 2)
        self.assertAlmostEqual(force, 2, delta=0.1)
        self.assertLess(force_error, 0.3)
        self.assertTrue(tactus.Tape(self.at("circle.tape")).replay().same_bits)

    def test_the_study_finds_the_threshold(self):
        out = example("stiffness_discrimination.py", "--simulated", "--seeds", 200).stdout
        print(out, end="")
        ratio = float(re.search(r"ratio (\d+\.\d+)", out).group(1))
        self.assertAlmostEqual(ratio, 1, delta=0.05)

    @long
    def test_the_study_goes_on_after_a_break(self):
        whole, broken = self.at("whole"), self.at("broken")
        example("stiffness_discrimination.py", "--simulated", "--folder", whole)
        with open(os.path.join(whole, "trials.csv"), "rb") as file:
            rows = file.read()
        self.assertGreater(rows.count(b"\n"), 20)
        tapes = sorted(name for name in os.listdir(whole) if name.endswith(".tape"))
        self.assertEqual(len(tapes), 2 * (rows.count(b"\n") - 1))
        self.assertTrue(tactus.Tape(os.path.join(whole, tapes[-1])).replay().same_bits)
        os.mkdir(broken)
        with open(os.path.join(broken, "trials.csv"), "wb") as file:  # as a break within the 12th row leaves it
            lines = rows.splitlines(keepends=True)
            file.write(b"".join(lines[:12]) + lines[12][:5])
        example("stiffness_discrimination.py", "--simulated", "--folder", broken)
        with open(os.path.join(broken, "trials.csv"), "rb") as file:
            self.assertEqual(file.read(), rows)
        other = example("stiffness_discrimination.py", "--simulated", "--folder", broken, "--seed", 7, check=False)
        self.assertEqual((other.returncode, other.stderr.count("\n")), (1, 1), other.stderr)
        self.assertIn("its study has seed 1", other.stderr)
        with open(os.path.join(broken, "trials.csv"), "rb") as file:
            self.assertEqual(file.read(), rows)
        with open(os.path.join(whole, "trials.csv"), newline="", encoding="utf-8") as file:
            first = {row["stiffer_interval"] for row in csv.DictReader(file)}
        self.assertEqual(first, {"1", "2"})


    def test_a_person_who_leaves_breaks_the_study_off_in_a_line(self):
        left = example("stiffness_discrimination.py", "--folder", self.at("person"), check=False, stdin=subprocess.DEVNULL)
        self.assertEqual(left.returncode, 1)
        self.assertEqual(left.stderr.strip(), "stiffness_discrimination: broken off; the same command goes on")
        with open(os.path.join(self.at("person"), "trials.csv"), "w", encoding="utf-8") as file:
            file.write("a,b\n1,2\n")
        wrong = example("stiffness_discrimination.py", "--folder", self.at("person"), check=False, stdin=subprocess.DEVNULL)
        self.assertEqual((wrong.returncode, wrong.stderr.count("\n")), (1, 1), wrong.stderr)
        self.assertIn("is no table of this study", wrong.stderr)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=1)
