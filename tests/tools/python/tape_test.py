#!/usr/bin/python3
"""tests/tools/python/tape_test.py PROGRAM FOLDER: tactus.Tape against the files of `tactus export`, bit by bit."""
import csv
import os
import subprocess
import sys
import tempfile
import unittest

import bench
import numpy as np
import tactus
from patience import PATIENCE_S, wait_for


class Tapes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.of_program = cls.at("program.tape")
        bench.run("card_house", 3, "--record", cls.of_program)
        cls.of_hand = cls.at("hand.tape")
        session = tactus.Session(bench.scene("press"), hand=lambda tick, pose, force: start + [0, 0, -0.01 * (tick > 50)])
        start = session.position[0].copy()
        session.record(cls.of_hand)
        session.step(1500)
        cls.hand_ticks = session.look()
        session.close()

        cls.of_mouse = cls.at("mouse.tape")
        cls.lead_by_pointer(cls.of_mouse)

    @classmethod
    def lead_by_pointer(cls, tape):
        """A run whose hand is led as the page's mouse leads it: by the control socket, with the pointer's hand."""
        socket = cls.at("c.sock")
        with subprocess.Popen([bench.PROGRAM, "run", bench.scene("press"), "--virtual-time", "--pace", "0.5", "--duration", "3600",
                               "--hand", "pointer", "--control", socket, "--record", tape], stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE) as process:
            try:
                live = wait_for(lambda: cls.open(socket, process), "controller")
                live.take_hand()
                start = wait_for(lambda: (ticks := live.look())["tick"].size and ticks)["tool_position_x_m"][-1]

                def moved():
                    try:
                        live.lead_hand((0.03, 0, -0.02))
                    except tactus.UseError:  # it was silent for too long
                        live.take_hand()
                    return np.any(live.look()["tool_position_x_m"] > start + 0.01)

                wait_for(moved)
                live.request("stop")
                process.wait(PATIENCE_S)
            finally:
                process.kill()

    @staticmethod
    def open(socket, process):
        try:
            return tactus.Live(socket)
        except tactus.MachineError:
            if process.poll() is not None:
                raise
            return None

    @classmethod
    def tearDownClass(cls):
        cls.scratch.cleanup()

    @classmethod
    def at(cls, name):
        return os.path.join(cls.scratch.name, name)

    def test_columns_are_those_of_the_export(self):
        for path in (self.of_program, self.of_mouse, self.of_hand):
            with self.subTest(tape=path):
                exported = self.at("exported.csv")
                subprocess.run([bench.PROGRAM, "export", path, "--csv", exported, "--overwrite"], check=True,
                               stdout=subprocess.DEVNULL)
                with open(exported, newline="", encoding="utf-8") as file:
                    rows = list(csv.reader(file))
                tape = tactus.Tape(path)
                self.assertEqual(list(tape), rows[0])
                self.assertEqual(len(tape), len(rows) - 1)
                for column, name in enumerate(rows[0]):
                    values = tape[name]
                    written = np.array([row[column] for row in rows[1:]], dtype=str).astype(
                        np.float64 if values.dtype == np.float64 else np.uint64)
                    self.assertTrue(np.array_equal(values.astype(written.dtype).view(np.uint64), written.view(np.uint64)),
                                    name)

    def test_a_tape_of_a_session_replays_and_has_its_ticks(self):
        tape = tactus.Tape(self.of_hand)
        self.assertTrue(np.array_equal(tape["force_z_N"], self.hand_ticks["force_N"][:, 2]))
        self.assertGreater(np.abs(tape["force_z_N"]).max(), 0.1)
        self.assertTrue(np.array_equal(tape["tick"], np.arange(1500)))
        replay = tape.replay()
        self.assertTrue(replay.same_bits)
        self.assertEqual((replay.ticks, replay.compared, replay.different, replay.damage), (1500, 1500, 0, ""))
        program = bench.program("replay", self.of_hand)
        self.assertTrue(program["good"])

    def test_a_tape_of_a_mouses_hand_has_its_way_and_replays(self):
        tape = tactus.Tape(self.of_mouse)
        self.assertEqual(tape.damage, "")
        self.assertGreater(np.ptp(tape["tool_position_x_m"]), 0.01)
        replay = tape.replay()
        self.assertTrue(replay.same_bits)
        self.assertEqual((replay.compared, replay.different), (len(tape), 0))

    def test_columns_are_read_only_and_keep_the_tape(self):
        force = tactus.Tape(self.of_hand)["force_z_N"]
        again = tactus.Tape(self.of_hand)["force_z_N"].copy()
        self.assertFalse(force.flags.writeable)
        self.assertTrue(np.array_equal(force, again))
        tape = tactus.Tape(self.of_hand)
        address = tape["proxy_position_x_m"].__array_interface__["data"][0]
        self.assertEqual(tape["proxy_position_x_m"].__array_interface__["data"][0], address)

    def test_cycles_faults_gaps(self):
        tape = tactus.Tape(self.of_program)
        self.assertEqual(tape.cycles[0], 0)
        self.assertTrue((np.diff(tape.cycles) >= 10).all())
        self.assertTrue(np.array_equal(tape["tick"][tape["adopts"] == 1], tape.cycles))
        self.assertEqual((tape.faults, tape.gaps, tape.damage), ([], [], ""))
        self.assertEqual(tape.about("force_z_N")["unit"], "N")
        faulty = self.at("faulty.tape")
        bench.run("press", 1, "--inject", "unplugged@300", "--record", faulty)
        ((tick, code, words),) = tactus.Tape(faulty).faults
        self.assertEqual((tick, code), (300, 2))
        self.assertIn("unplugged", words)

    def test_what_is_damaged_is_said_as_the_replay_says_it(self):
        with open(self.of_program, "rb") as file:
            whole = bytearray(file.read())
        damaged = self.at("damaged.tape")
        start, length = len(whole) // 2, len(whole) // 10  # longer than any record that is no tick's
        whole[start:start + length] = bytes(byte ^ 0xff for byte in whole[start:start + length])
        with open(damaged, "wb") as file:
            file.write(whole)
        program = bench.program("replay", damaged)
        tape = tactus.Tape(damaged)
        self.assertEqual(tape.damage, program["damage"])
        self.assertEqual(tape.replay().damage, program["damage"])
        self.assertEqual(sum(ticks for _, ticks in tape.gaps), program["lost_ticks"])
        self.assertLess(len(tape), 3000)

    def test_what_is_no_tape_is_one_line(self):
        text = self.at("text.tape")
        with open(text, "w", encoding="utf-8") as file:
            file.write("no tape")
        for path in (text, self.at("nowhere.tape")):
            with self.assertRaises(tactus.FileError) as caught:
                tactus.Tape(path)
            self.assertNotIn("\n", str(caught.exception))
        tape = tactus.Tape(self.of_hand)
        with self.assertRaisesRegex(KeyError, "did you mean force_z_N"):
            tape["force_z"]
        for wrong in (0, None, b"tick", slice(3)):
            with self.assertRaisesRegex(tactus.OptionError, "is no column"):
                tape[wrong]
            with self.assertRaisesRegex(tactus.OptionError, "is no column"):
                tape.about(wrong)
            self.assertNotIn(wrong, tape)
        with self.assertRaises(KeyError):
            tape["\ud800"]
        for path, error, said in ((None, tactus.OptionError, "is no path"), (3, tactus.OptionError, "is no path"),
                                  ("a\0b", tactus.OptionError, "is no path"), ("x\udc80.tape", tactus.FileError, r"x\\x80.tape")):
            with self.subTest(path=path), self.assertRaisesRegex(error, said) as caught:
                tactus.Tape(path)
            self.assertNotIn("\n", str(caught.exception))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=1)
