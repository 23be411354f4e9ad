#!/usr/bin/python3
"""tests/tools/python/live_test.py PROGRAM FOLDER: tactus.Live on a running program in virtual time. Nothing is judged by a clock."""
import gc
import os
import signal
import subprocess
import sys
import tempfile
import unittest

import bench
import numpy as np
import tactus
from patience import PATIENCE_S, wait_for


class Run:
    """A program that runs until it is stopped."""

    def __init__(self, folder, *options, scene="press"):
        self.socket, self.tape = os.path.join(folder, "c.sock"), os.path.join(folder, "run.tape")
        self.process = subprocess.Popen(
            [bench.PROGRAM, "run", bench.scene(scene), "--virtual-time", "--pace", "0.5", "--duration", "3600",
             "--control", self.socket, "--record", self.tape, *options], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    def live(self):
        def found():
            try:
                return tactus.Live(self.socket)
            except tactus.MachineError:
                if self.process.poll() is not None:
                    raise
                return None

        return wait_for(found, "controller")

    def kill(self):
        self.process.kill()
        self.process.wait()
        self.process.stderr.close()


def first_ticks(live):
    return wait_for(lambda: (ticks := live.look())["tick"].size and ticks)


class Watching(unittest.TestCase):
    def start(self, *options, scene="press"):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        run = Run(folder.name, *options, scene=scene)
        self.addCleanup(run.kill)
        return run, run.live()

    def test_what_is_seen_is_what_is_on_the_tape(self):
        run, live = self.start()
        seen = []

        def enough():
            ticks = live.look()
            self.assertEqual(live.ticks_lost, 0)
            if len(ticks["tick"]):
                seen.append(ticks)
            return sum(len(ticks["tick"]) for ticks in seen) > 400

        wait_for(enough)
        frame = wait_for(live.frame)
        live.request("stop")
        wait_for(lambda: live.ended)
        self.assertEqual(run.process.wait(PATIENCE_S), 0, run.process.stderr.read())
        tape = tactus.Tape(run.tape)
        numbers = np.concatenate([ticks["tick"] for ticks in seen])
        np.testing.assert_array_equal(np.diff(numbers), 1)
        rows = np.searchsorted(tape["tick"], numbers)
        for column in tape.columns:
            with self.subTest(column=column):
                np.testing.assert_array_equal(np.concatenate([ticks[column] for ticks in seen]), tape[column][rows])
        self.assertEqual((live.scene_text, live.scene_name, live.period_s), (tape.scene_text, tape.scene_name, tape.period_s))
        self.assertEqual(frame["position"].shape, (len(live.moving), 3))

    def test_a_frame_has_the_bodies(self):
        _, live = self.start()
        frame = wait_for(live.frame)
        session = tactus.Session(bench.scene("press"))
        fixed = [i for i, body in enumerate(session.bodies) if i not in live.moving]
        self.assertTrue(all(session.bodies[i]["mass_kg"] == 0 for i in fixed))
        session.step(max(1, int(round(frame["time_s"] / session.period_s))))
        np.testing.assert_allclose(frame["position"], session.position[live.moving], atol=2e-3)
        np.testing.assert_allclose(np.linalg.norm(frame["rotation"], axis=1), 1, atol=1e-12)
        self.assertEqual(frame["roles"].shape, (len(live.moving),))
        while frame["contacts"].size == 0:
            frame = wait_for(live.frame)
        contacts = frame["contacts"]
        self.assertEqual(contacts.dtype.names, ("position_m", "force_N", "a", "b"))

    def test_a_frames_poses_are_of_the_frames_that_the_scene_places(self):
        _, live = self.start(scene="cups")
        frame = wait_for(live.frame)
        session = tactus.Session(bench.scene("cups"))
        off = np.array([np.linalg.norm(body["centre_of_mass_m"]) for body in session.bodies])[live.moving]
        self.assertGreater(off.max(), 5e-3)
        session.step(max(1, int(round(frame["time_s"] / session.period_s))))
        np.testing.assert_allclose(frame["position"], session.position[live.moving], atol=2e-3)

    def test_views_outlive_what_they_came_from_and_are_read_only(self):
        run, live = self.start()
        ticks = first_ticks(live)
        before = ticks["force_z_N"].copy()
        live.close()
        run.kill()
        del live
        gc.collect()
        np.testing.assert_array_equal(ticks["force_z_N"], before)
        with self.assertRaises(ValueError):
            ticks["force_z_N"][0] = 1

    def test_requests_and_refusals(self):
        _, live = self.start()
        self.assertTrue(live.request("pause")["ok"])
        self.assertIn("verdict", wait_for(live.state))
        for refused in ("juggle", "reset now", "hand 0 take"):
            with self.subTest(refused=refused), self.assertRaises(tactus.UseError) as raised:
                live.request(refused)
            self.assertNotIn("\n", str(raised.exception))
        with self.assertRaises(tactus.OptionError):
            live.request("state\nstop")
        with self.assertRaises(tactus.UseError):
            live.lead_hand((0.01, 0, 0))  # it was not taken
        live.close()
        with self.assertRaises(tactus.UseError):
            live.look()

    def test_a_pointers_hand_is_led(self):
        _, live = self.start("--hand", "pointer")
        live.take_hand()
        start = first_ticks(live)["tool_position_x_m"][-1]

        def moved():
            try:
                live.lead_hand((0.03, 0, 0))
            except tactus.UseError:  # this process was silent for too long
                live.take_hand()
            return np.any(live.look()["tool_position_x_m"] > start + 0.01)

        wait_for(moved)
        live.rest_hand()
        with self.assertRaises(tactus.UseError):
            live.lead_hand((10**6, 0, 0))

    def test_one_of_two_in_the_same_process_has_the_hand(self):
        run, first = self.start("--hand", "pointer")
        second = run.live()
        self.assertNotEqual(first._hand, second._hand)
        first.request("pause")  # time of the run stands; silence is counted by the clock, so each asks at once after
        wait_for(lambda: self.holds(first, second))
        first.rest_hand()
        second.take_hand()

    def holds(self, first, second):
        """Did the second get a refusal while the first has the hand?"""
        first.take_hand()
        try:
            second.take_hand()
        except tactus.UseError as error:
            self.assertIn("has the hand", str(error))
            return True
        second.rest_hand()
        return False  # the first was silent for too long

    def test_what_is_no_socket_and_no_request_is_one_line(self):
        _, live = self.start("--hand", "pointer")
        for wrong in (None, 3, "a\0b"):
            with self.assertRaisesRegex(tactus.OptionError, "Live: .* is no path"):
                tactus.Live(wrong)
        with self.assertRaises(tactus.MachineError) as raised:
            tactus.Live("x\udc80")
        self.assertIn("x\\x80", str(raised.exception))
        for wrong in (3, None, b"state"):
            with self.assertRaisesRegex(tactus.OptionError, "Live: request: "):
                live.request(wrong)
        with self.assertRaises(tactus.UseError):
            live.request("\ud800")
        for wrong in ("abc", (1, 2), 3, None, (1, 2, "x"), (1, 2, 3, 4)):
            with self.subTest(wrong=wrong), self.assertRaisesRegex(tactus.OptionError, "3 and 3 numbers"):
                live.lead_hand(wrong)

    def test_a_controller_that_vanishes_is_one_line(self):
        run, live = self.start()
        wait_for(live.frame)
        os.kill(run.process.pid, signal.SIGKILL)
        run.process.wait()
        wait_for(lambda: live.ended)
        live.look()
        live.frame()
        with self.assertRaises(tactus.MachineError) as raised:
            live.request("state")
        self.assertNotIn("\n", str(raised.exception))
        with self.assertRaises(tactus.MachineError) as raised:
            tactus.Live("/nowhere/c.sock")
        self.assertIn("/nowhere/c.sock", str(raised.exception))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=1)
