#!/usr/bin/python3
"""Every table of RESULTS.md stands between marks that tools/results knows, under a stamp; what measures them goes on after an
interruption, and its rows follow from the experiments' JSON."""
import importlib.machinery
import importlib.util
import io
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "tools")]
from result_tables import border, engines, instructions, page, parts, words  # noqa: E402



def script(name):
    """A script without .py as a module."""
    loader = importlib.machinery.SourceFileLoader(name, str(ROOT / "tools" / name))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(name, loader))
    loader.exec_module(module)
    return module


results = script("results")
source_figures = script("source_figures")

STAMP = page.stamp(["2026-11-28", "2026-11-27"], "0123456789ab", "AMD EPYC, 2 cores", "`tactus experiment scaling`")
TABLE = "| a |\n| --- |\n| 1 |"


def block(name, stamp=STAMP, table=TABLE):
    return f"<!-- results: {name} -->\n{stamp}\n\n{table}\n<!-- end -->\n"


class Page(unittest.TestCase):
    def test_every_table_of_the_page_has_marks_and_a_stamp(self):
        self.assertEqual(page.faults(results.PAGE.read_text(encoding="utf-8"), results.TABLES), [])

    def test_a_right_page_has_no_fault(self):
        self.assertEqual(page.faults(block("one") + "text\n" + block("two"), ["one", "two"]), [])

    def test_each_fault_is_found(self):
        for text, word in ((block("one") + TABLE + "\n", "between no marks"), (block("one") + block("two"), "no such table"), ("", "stands 0"),
                           (block("one") * 2, "stands 2"), (block("one", stamp=""), "no line"), (block("one", table="none"), "0 tables"),
                           (block("one", table=TABLE + "\n\n" + TABLE), "2 tables"),
                           (block("one", STAMP.replace("2026-11-27", "yesterday")), "no date"),
                           (block("one", STAMP.replace("0123456789ab", "0123456789ab-dirty")), "no commit"),
                           (block("one", STAMP.replace("`tactus experiment scaling`", "by hand")), "no command"),
                           (block("one", STAMP.replace("machine AMD EPYC, 2 cores; ", "")), "no stamp"),
                           (block("one", STAMP.replace("AMD EPYC, 2 cores", "not known")), "to be measured again")):
            with self.subTest(word):
                found = page.faults(text, ["one"])
                self.assertTrue(any(word in line for line in found), found)

    def test_a_stamp_may_name_its_rows_and_what_is_not_known(self):
        stamp = STAMP.replace("Measured:", "Measured (row two):").replace("0123456789ab", "not known (written in 0177c15), to be measured again")
        self.assertEqual(page.faults(block("one", STAMP + "\n\n" + stamp), ["one"]), [])

    def test_a_table_is_written_in_its_place_and_nothing_else_changes(self):
        text = "before\n" + block("one") + "between\n" + block("two") + "after\n"
        self.assertEqual(page.replaced(text, "two", "S", "T"), "before\n" + block("one") + "between\n" + block("two", "S", "T") + "after\n")
        self.assertIsNone(page.replaced(text, "three", "S", "T"))

    def test_every_table_says_what_it_runs_and_how_long_it_takes(self):
        for name, table in results.TABLES.items():
            with self.subTest(name):
                made = table.parts("0123456")
                self.assertTrue(made)
                self.assertEqual(len({part.name for part in made}), len(made), "two parts of one name would be one file")
                self.assertEqual(page.stamp_faults(page.stamp(["2026-11-28"], "0123456789ab", "PC", table.command)), [])
                self.assertIn(table.takes, results.listed())
                for word in (w for part in made for w in part.words if w.endswith(".toml")):
                    self.assertTrue((ROOT / word).is_file(), word)


class Parts(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.build = pathlib.Path(self.folder.name) / "build"
        (self.build / "tools").mkdir(parents=True)
        (self.build / "tools/tactus").write_text("one program", encoding="utf-8")
        self.said = io.StringIO()
        for replaced in (mock.patch.object(parts, "KEPT", pathlib.Path(self.folder.name) / "kept"), mock.patch.object(sys, "stderr", self.said)):
            replaced.start()
            self.addCleanup(replaced.stop)
        self.ran = []

    def part(self, name, stops=False):
        def measure(part, _bench):
            if stops:
                raise KeyboardInterrupt
            self.ran.append(part.name)
            return {"of": part.name}
        return parts.Part(name, ("tactus", name), 1, measure)

    def measured(self, made, each=lambda done: None):
        return parts.measured("t", made, parts.Bench(self.build), each)

    def test_an_interrupted_table_goes_on_where_it_stopped(self):
        seen = []
        with self.assertRaises(KeyboardInterrupt):
            self.measured([self.part("a"), self.part("b", stops=True), self.part("c")], lambda done: seen.append(len(done)))
        done = self.measured([self.part(name) for name in "abc"], lambda done: seen.append(len(done)))
        self.assertEqual(self.ran, ["a", "b", "c"])
        self.assertEqual([one.data for one in done], [{"of": name} for name in "abc"])
        self.assertEqual(seen, [1, 1, 2, 3])
        self.assertRegex(self.said.getvalue(), r"t: part 3 of 3, 67 %, about \d+ s left: tactus c\n$")

    def test_another_program_or_command_is_measured_again(self):
        self.measured([self.part("a")])
        (self.build / "tools/tactus").write_text("another program", encoding="utf-8")
        self.measured([self.part("a")])
        self.assertEqual(self.ran, ["a", "a"])

    def test_a_file_that_is_cut_off_is_measured_again(self):
        self.measured([self.part("a")])
        path = parts.KEPT / "t/a.json"
        path.write_text(path.read_text(encoding="utf-8")[:20], encoding="utf-8")
        self.measured([self.part("a")])
        self.assertEqual(self.ran, ["a", "a"])

    def test_a_program_without_json_is_a_failure_that_names_it(self):
        (self.build / "tools/tactus").write_text("#!/bin/sh\necho no JSON\nexit 3\n", encoding="utf-8")
        (self.build / "tools/tactus").chmod(0o755)
        made = parts.Part("a", ("tactus", "experiment", "scaling"), 1, parts.run_json)
        with self.assertRaisesRegex(parts.Failed, "tactus experiment scaling: ended with status 3"):
            self.measured([made])

    def test_an_error_that_the_program_prints_is_a_failure_and_is_not_kept(self):
        (self.build / "tools/tactus").write_text("#!/bin/sh\necho '{\"error\": \"no such scene\"}'\nexit 2\n", encoding="utf-8")
        (self.build / "tools/tactus").chmod(0o755)
        made = parts.Part("a", ("tactus", "experiment", "scaling"), 1, parts.run_json)
        with self.assertRaisesRegex(parts.Failed, "tactus experiment scaling: no such scene"):
            self.measured([made])
        self.assertFalse((parts.KEPT / "t/a.json").exists())


def done(name, data, revision=""):
    return parts.Done(parts.Part(name, ("tactus", name), 1, None, revision), data, "2026-11-28")


def cells(table):
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()[2:]]


def whole_row(members, ratio, off_m=0.0, **others):
    return {"coupling": "sub-world", "hand": "closed", "scene": "s", "members": members, "ratio": ratio, "force_error": 0.0059,
            "force_rms_N": 1.0, "pose_off_m": off_m, "pose_off_share_of_size": None, "energy_gain_J": 0.0, "direct_energy_gain_J": 0.0,
            "energy_at_play_J": 2.0, "border_spent_share": 0.0, "stands": True, **others}


def peer_row(engine, median_us, **others):
    return {"scene": "pile64-stirred", "engine": engine, "median_us": median_us, "worst_over_median": 1.0, "penetration_mean_m": 1e-4,
            "penetration_max_m": 3e-3, "travel_m": 0.5, "residual_speed_rms_m_per_s": 2e-8, "is_compared": True, "missed_gate": "", "failure": "",
            **others}


class Rows(unittest.TestCase):
    def test_caps_with_the_same_figures_are_one_row_of_whole_runs(self):
        rows = [whole_row(cap, ratio) for cap in (16, 8) for ratio in border.WHOLE_RATIOS]
        rows += [whole_row(4, ratio, off_m=0.01, pose_off_share_of_size=0.255, stands=ratio < 16, energy_gain_J=0.1,
                           direct_energy_gain_J=0.04, border_spent_share=ratio / 160) for ratio in border.WHOLE_RATIOS]
        rows += [whole_row(16, 1, coupling="direct", force_error=error, pose_off_share_of_size=off)
                 for error, off in ((0.001, 0.3), (0.022, None))]
        rows += [whole_row(16, 2, hand="direct", off_m=1)]
        self.assertEqual(cells(border.whole([done("s", {"whole": rows})])), [
            ["s, 16 or 8", "0.59, 0.59, 0.59, 0.59, 0.59", "2.2", "0.00, 0.00, 0.00, 0.00, 0.00", "-", "30.0 %", "0.00", "0.0",
             "yes"],
            ["s, 4", "0.59, 0.59, 0.59, 0.59, 0.59", "2.2", "10.00, 10.00, 10.00, 10.00, 10.00", "25.5 %", "30.0 %", "3.00", "10.0",
             "NO at 16"]])

    def test_each_coupling_has_its_force_at_both_ratios(self):
        rows = [{"scene": "s", "coupling": c, "ratio": ratio, "force_error_rms": error, "stable": error < 0.5}
                for c, ratio, error in (("direct", 1, 0.0), ("sub-world", 8, 0.01), ("sub-world", 16, 0.02), ("static", 8, 0.7))]
        self.assertEqual(cells(border.couplings([done("s", {"rows": rows})])), [["s", "1.0 % / 2.0 %", "70 %, unstable / -"]])

    def test_a_ratio_that_a_scene_refuses_is_a_dash(self):
        self.assertEqual(cells(border.whole([done("s", {"whole": [whole_row(4, 8, force_rms_N=0.0)]})]))[0][1:4], ["no force", "-", "-, -, 0.00, -, -"])

    def test_three_caps_are_at_least_two_members(self):
        by_name = {file.stem: border.three_caps(file) for file in border.scene_files()}
        self.assertEqual([by_name[name] for name in ("two_cubes", "cradle", "table", "wall")], [[2], [3, 2], [6, 3, 2], [64, 32, 16]])

    def test_forces_that_are_felt_are_bold_in_the_border_scenes(self):
        rows = [whole_row(2, ratio, force_error=error) for ratio, error in ((2, 0.054), (8, 0.05), (16, 0.31))]
        self.assertEqual(cells(border.border_scenes([done("s", {"whole": rows})])), [["s, 2", "**5.4**, 5.0, **31** %", "0.00, 0.00, 0.00 mm", "yes"]])

    def test_random_worlds_are_summed_over_their_parts(self):
        one = {"worlds": 100, "with_border": 90, "standing_bodies": 600, "collapsed": 2, "overlapping": 1, "still_fallen": 1, "by_chance": 3,
               "gain_energy": 4, "left_out": [7], "noted": [{"seed": 5, "outcome": "collapses"}, {"seed": 6, "outcome": "falls by chance"},
                                                            {"seed": 8, "outcome": "collapses, overlapping from the start"}]}
        other = {**one, "noted": [{"seed": 105, "outcome": "collapses: what stood still falls"}]}
        self.assertEqual([row[1] for row in cells(border.random_worlds([done("0", one), done("1", other)]))],
                         ["200", "2", "198", "180", "1,200", "4", "2", "2", "5, 105", "6", "8"])

    def test_the_best_peer_is_the_fastest_that_passes(self):
        rows = [peer_row("tactus", 50.0), peer_row("bullet", 200.0), peer_row("bullet-tuned-4", 100.0),
                peer_row("ode", 10.0, is_compared=False, missed_gate="43 % deep")]
        row = cells(engines.peers([done("p", {"rows": rows})]))[0]
        self.assertEqual(row[:6], ["`pile64-stirred`", "1 ms", "50", "100: Bullet, tuned, 4 iterations", "0.50", "200 (0.25)"])
        row = cells(engines.peers([done("p", {"rows": [rows[0], rows[3], peer_row("bullet", 9.0, is_compared=False, missed_gate="43 % deep")]})]))[0]
        self.assertEqual(row[3:7], ["none passes", "-", "9, fails: 43 % deep", "0.10 / - / 0.10"])

    def test_goals_are_those_whose_parts_are_measured(self):
        scaling = {"exponent": 1.03, "instruction_exponent": None, "rows": [{"sweep": "sizes", "size_ratio": ratio, "broad_phase_us": us}
                                                                           for ratio, us in ((1.0, 300.0), (20.0, 270.0))]}
        self.assertEqual([row[1] for row in cells(engines.goals([done("scaling", scaling)]))],
                         ["time to the power 1.03 of the contact points", "0.9 times (270 and 300 µs), settled"])

    def test_a_base_that_lacks_a_row_is_a_dash(self):
        parts_done = [done("terrain1000", {"points": 13769.0, "instructions": 77.2e6}), done("terrain1000-before", {}, "f2a9163"),
                      done("pile1000", {"points": 4125.0, "instructions": 6.51e6}), done("pile1000-before", {"points": 1.0, "instructions": 6.62e6}, "f2a9163")]
        self.assertEqual(cells(instructions.step_instructions(parts_done)),
                         [["`terrain1000`", "13,769", "154.4", "-", "77.2", "0.50"], ["`pile1000`", "4,125", "6.51", "6.62", "6.51", "1.00"]])

    def test_instructions_of_a_tick_are_those_of_two_functions_with_what_they_call(self):
        text = "\n".join(["events: Ir", "fn=(1) tactus::haptics::SubWorld::step(int)", "10 5", "cfn=(2) tactus::haptics::SubWorld::step_members(int)",
                          "calls=1 20", "+1 100", "fn=(2)", "20 100", "fn=(3) tactus::haptics::SubWorld::synchronise(int)", "* 7", "fn=(4) main",
                          "1 900", "cfn=(1)", "calls=1 10", "2 105", "fn=(5) tactus::sim::SubWorldPrediction::run(int)",
                          "1 3", "cfn=(1)", "calls=1 10", "2 40", "totals: 1012", ""])
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "callgrind.out"
            path.write_text(text, encoding="utf-8")
            self.assertEqual(instructions.inclusive(path, instructions.TICK_PARTS, instructions.OF_GLOBAL_STEP), 72)

    def test_numbers_have_the_digits_that_a_reader_needs(self):
        for made, expected in ((words.percent(0.0033), "0.33 %"), (words.percent(0.073), "7.3 %"), (words.percent(0.0999), "10 %"),
                               (words.percent(12), "> 1000 %"), (words.digits(0), "0"), (words.digits(0.994), "0.99"), (words.digits(0.999), "1.0"),
                               (words.three(0.0871), "0.087"), (words.three(0.364), "0.36"), (words.overlap_mm(0.012), "12"),
                               (words.overlap_mm(0.0072), "7.2"), (words.duration(59), "59 s"), (words.duration(5400), "90 min"),
                               (words.duration(7200), "2.0 h")):
            self.assertEqual(made, expected)


class SourceFigures(unittest.TestCase):
    def test_a_function_has_the_lines_from_its_name_to_its_last_brace_and_its_parameters(self):
        text = ("int f(int a, std::pair<int, int> b) noexcept {\n  if (a) {\n    return 1;\n  }\n  return g(a, 2, 3);\n}\n"
                "struct S {\n  S() : a_(1), b_{2} {}\n  void h(int);\n};\n// void not_one() {\n")
        self.assertEqual(list(source_figures.functions(text)), [("f", 6, 2), ("S", 1, 0)])

    def test_the_choices_are_named_in_ten_files_at_most_and_no_function_has_more_than_six_parameters(self):
        rows = source_figures.figures("")
        for choice in source_figures.CHOICES:
            self.assertLessEqual(int(rows[f"files that name {choice}, without tests"]), 10)
        self.assertLessEqual(int(rows["most parameters, without tests"].split(":")[0]), 6)


if __name__ == "__main__":
    unittest.main()
