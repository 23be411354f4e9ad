#!/usr/bin/python3
"""tests/tools/python/session_test.py PROGRAM FOLDER: tactus.Session against the program, and what must not break."""
import gc
import os
import resource
import sys
import tempfile
import threading
import time
import unittest

import bench
import numpy as np
import tactus
from long import LONG, long

SCENES = sorted(name[:-5] for name in os.listdir(bench.SCENES) if name.endswith(".toml"))
SOME = SCENES if LONG else SCENES[::3]
TICKS = {"pile700": 60, "pile5000": 20, "heaps50k": 20}  # of 600: these are for minutes


class Bits(unittest.TestCase):
    def test_every_scene_has_the_programs_bits(self):
        for name in SOME:
            with self.subTest(scene=name):
                session, ticks = tactus.Session(bench.scene(name)), TICKS.get(name, 600)
                session.step(ticks)
                self.assertEqual(session.state_hash, bench.run(name, ticks * session.period_s)["state_hash"])

    def test_options_are_the_programs(self):
        session = tactus.Session(bench.scene("press"), coupling="static", ratio=5, rate_Hz=2000.0, members=4)
        session.step(1000)
        expected = bench.run("press", 0.5, "--coupling", "static", "--ratio", 5, "--rate", 2000, "--members", 4)
        self.assertEqual(session.state_hash, expected["state_hash"])
        self.assertEqual(session.summary()["state_hash"], expected["state_hash"])

    def test_a_saved_state_continues_with_the_same_bits(self):
        for name in SOME:
            with self.subTest(scene=name):
                session, ticks = tactus.Session(bench.scene(name)), min(TICKS.get(name, 100), 100)
                session.step(min(TICKS.get(name, 237), 237))
                saved = session.save()
                session.step(ticks)
                expected = session.state_hash
                session.restore(saved)
                session.step(ticks)
                self.assertEqual(session.state_hash, expected)

    def test_a_reset_restarts_the_run(self):
        session = tactus.Session(bench.scene("press"))
        position = session.position
        session.step(500)
        expected, moved = session.state_hash, position.copy()
        session.reset()
        self.assertEqual(session.ticks, 0)
        self.assertFalse(np.array_equal(position, moved))
        session.step(500)
        self.assertEqual(session.state_hash, expected)
        self.assertTrue(np.array_equal(position, moved))

    def test_two_threads_have_the_bits_of_one(self):
        def hashes(threads):
            sessions = [tactus.Session(bench.scene("card_house")) for _ in range(2)]
            began = time.monotonic()
            if threads:
                workers = [threading.Thread(target=session.step, args=(2000,)) for session in sessions]
                for worker in workers:
                    worker.start()
                for worker in workers:
                    worker.join()
            else:
                for session in sessions:
                    session.step(2000)
            return [session.state_hash for session in sessions], time.monotonic() - began

        (alone, alone_s), (beside, beside_s) = hashes(False), hashes(True)
        self.assertEqual(alone, beside)
        print(f"two sessions of 2000 ticks: one after the other {alone_s:.2f} s, in two threads {beside_s:.2f} s")


class Views(unittest.TestCase):
    def setUp(self):
        self.session = tactus.Session(bench.scene("card_house"))

    def test_shapes_types_and_no_copy(self):
        session, bodies = self.session, len(self.session.bodies)
        for name, shape in (("position", (bodies, 3)), ("rotation", (bodies, 4)), ("velocity", (bodies, 3)),
                            ("angular_velocity", (bodies, 3)), ("roles", (bodies,))):
            view = getattr(session, name)
            self.assertEqual(view.shape, shape, name)
            self.assertEqual(view.dtype, np.uint8 if name == "roles" else np.float64)
            address = view.__array_interface__["data"][0]
            session.step(7)
            self.assertEqual(getattr(session, name).__array_interface__["data"][0], address)
            with self.assertRaises(ValueError):
                view[...] = 0
            with self.assertRaises(ValueError):
                view.flags.writeable = True

    def test_a_view_follows_and_is_the_bodies(self):
        position, velocity = self.session.position, self.session.velocity
        proxy = self.session.last["proxy_position_m"].copy()
        self.session.step(900)
        self.assertFalse(np.array_equal(position[0], proxy))
        self.assertTrue(np.array_equal(position[0], self.session.last["proxy_position_m"]))
        self.assertTrue(np.array_equal(velocity[0], self.session.last["proxy_velocity_m_per_s"]))
        self.assertTrue(np.allclose(np.linalg.norm(self.session.rotation, axis=1), 1, atol=1e-9))

    def test_a_view_keeps_its_memory(self):
        self.session.step(50)
        views = [tactus.Session(bench.scene("press")).position for _ in range(20)]
        expected = tactus.Session(bench.scene("press")).position.copy()
        gc.collect()
        noise = [np.ones(expected.shape) for _ in range(200)]
        for view in views:
            self.assertTrue(np.array_equal(view, expected))
        self.assertEqual(len(noise), 200)

    def test_a_replaced_scene_says_so_in_its_old_views(self):
        session = self.session
        session.step(900)
        position, rotation, roles, members = session.position, session.rotation, session.roles, session.members
        contacts = session.contacts
        self.assertGreater(len(contacts), 0)
        session.replace(bench.scene("press"))
        self.assertTrue(np.isnan(position).all() and np.isnan(rotation).all())
        self.assertTrue(np.isnan(contacts["force_N"]).all())
        self.assertTrue((roles == 255).all() and (members == 2**32 - 1).all())
        self.assertFalse(np.isnan(session.position).any())
        self.assertEqual(session.ticks, 0)

    def test_contacts_of_a_pressed_block_carry_its_weight(self):
        session = tactus.Session(bench.scene("press"))
        session.step(1500)
        contacts = session.contacts
        self.assertGreater(contacts["force_N"].sum(), 0)
        self.assertTrue(np.allclose(np.linalg.norm(contacts["normal"], axis=1), 1))
        self.assertIn("friction_N", contacts.dtype.names)
        self.assertTrue(set(session.members) >= set(contacts["a"]))
        session = tactus.Session(bench.scene("wall"), members=6)
        seen = 0
        for _ in range(40):
            session.step(50)
            border = session.border
            seen += len(border)
            for contact in border:
                self.assertEqual(session.roles[contact["member"]], 5)
        self.assertGreater(seen, 0)

    def test_ticks_since_the_last_look(self):
        session = tactus.Session(bench.scene("press"), history_ticks=1500)
        self.assertEqual(len(session.look()), 0)
        for count in (1, 250, 999):
            session.step(count)
        ticks = session.look()
        self.assertEqual(list(ticks["number"]), list(range(1250)))
        self.assertEqual(ticks["force_N"].shape, (1250, 3))
        self.assertEqual(session.ticks_lost, 0)
        self.assertTrue(np.array_equal(ticks[-1]["force_N"], session.last["force_N"]))
        self.assertEqual(len(session.look()), 0)
        session.step(4000)
        ticks = session.look()
        self.assertEqual((len(ticks), session.ticks_lost, ticks["number"][-1]), (1500, 2500, 5249))

    def test_a_fault_is_seen(self):
        session = tactus.Session(bench.scene("press"), inject="unplugged@300")
        session.step(400)
        faults = session.look()["fault"]
        self.assertEqual((faults[299], faults[-1]), (0, 2))


class Hand(unittest.TestCase):
    def test_a_resting_hand_rests(self):
        session = tactus.Session(bench.scene("press"), hand=lambda tick, pose, force: None)
        start = session.position[0].copy()
        session.step(500)
        self.assertLess(np.abs(session.position[0] - start).max(), 2e-3)

    def test_the_tool_goes_where_the_hand_wants_it(self):
        asked = []

        def hand(tick, pose, force):
            asked.append((tick, pose.shape, force.shape))
            return goal

        session = tactus.Session(bench.scene("free"), hand=hand)
        goal = session.position[0] + [0.01, -0.02, 0.005]
        session.step(3000)
        self.assertEqual([tick for tick, _, _ in asked], list(range(1, 3000)))
        self.assertEqual(set(asked[0][1:] + asked[-1][1:]), {(7,), (6,)})
        self.assertLess(np.linalg.norm(session.position[0] - goal), 2e-3)

    def test_pose_and_force_are_the_ticks(self):
        seen = []
        session = tactus.Session(bench.scene("press"), hand=lambda tick, pose, force: seen.append((pose, force)))
        session.step(1200)
        ticks = session.look()
        device_z = 0.0
        for (pose, _), tick in zip(seen, ticks):
            device_z = pose[2] - tick["tool_position_m"][2]
            self.assertAlmostEqual(device_z, seen[0][0][2] - ticks[0]["tool_position_m"][2], 9)
        felt = np.array([force[:3] for _, force in seen])
        self.assertTrue(np.array_equal(felt[2:], ticks["force_N"][1:-2]))

    def test_a_block_of_targets_is_the_function_of_the_same_targets(self):
        start = tactus.Session(bench.scene("press")).position[0].copy()
        targets = start + np.outer(np.linspace(0, 1, 1000), [0.004, 0, -0.02])
        by_function = tactus.Session(bench.scene("press"), hand=lambda tick, pose, force: targets[tick])
        by_function.step(1000)
        by_block = tactus.Session(bench.scene("press"), hand="targets")
        by_block.step(targets[:400])
        by_block.step(np.hstack([targets[400:], np.tile([2.0, 0, 0, 0], (600, 1))]))
        self.assertEqual(by_function.state_hash, by_block.state_hash)
        self.assertEqual(by_block.ticks, 1000)
        self.assertGreater(np.abs(by_block.look()["force_N"]).max(), 0.1)

    def test_a_wrench_pushes_the_tool_until_the_world_pushes_back(self):
        session = tactus.Session(bench.scene("press"), hand=lambda tick, pose, force: [0, 0, -3, 0, 0, 0])
        session.step(3000)
        ticks = session.look()[-200:]
        self.assertLess(np.abs(ticks["tool_position_m"] - ticks["tool_position_m"][0]).max(), 1e-4)  # at rest
        # Motors and push are in balance, but for the arm's Coulomb friction.
        self.assertAlmostEqual(ticks["force_N"][:, 2].mean(), 3, delta=0.5)

    def test_a_wrench_accelerates_the_tool_along_it(self):
        def way(wrench):
            session = tactus.Session(bench.scene("free"), hand="targets")
            start = session.position[0].copy()
            session.step(np.tile(np.array(wrench, float), (150, 1)))
            return session.position[0] - start

        for axis in range(3):
            wrench = np.zeros(6)
            wrench[axis] = 5
            moved, back = way(wrench), way(-wrench)
            self.assertGreater(moved[axis], 0.005)
            self.assertLess(back[axis], -0.005)
            self.assertLess(np.abs(np.delete(moved, axis)).max(), 0.1 * moved[axis])

    def test_wrenches_and_targets_mix_and_a_saved_push_continues(self):
        rows = np.zeros((120, 6))
        rows[:60, 0], rows[60:, 1] = 2, -2
        start = tactus.Session(bench.scene("free")).position[0].copy()

        def hand(tick, pose, force):
            return rows[tick] if tick < 120 else start if tick == 120 else None

        by_function = tactus.Session(bench.scene("free"), hand=hand)
        by_function.step(120)
        by_block = tactus.Session(bench.scene("free"), hand="targets")
        by_block.step(rows)
        self.assertEqual(by_function.state_hash, by_block.state_hash)
        saved = by_block.save()
        by_function.step(400)
        expected = by_function.state_hash
        for _ in range(2):
            by_block.step(np.tile(start, (400, 1)))
            self.assertEqual(by_block.state_hash, expected)
            by_block.restore(saved)
        by_function.step(3000)
        self.assertEqual(by_function.last["fault"], 0)
        self.assertLess(np.linalg.norm(by_function.position[0] - start), 2e-3)  # the target holds it again

    def test_a_saved_hand_continues(self):
        def hand(tick, pose, force):
            return start + [0.003 * np.sin(tick / 50), 0, -0.01]

        session = tactus.Session(bench.scene("press"), hand=hand)
        start = session.position[0].copy()
        session.step(777)
        saved = session.save()
        session.step(300)
        expected = session.state_hash
        session.restore(saved)
        session.step(300)
        self.assertEqual(session.state_hash, expected)

    def test_an_exception_comes_out_as_it_was_and_the_session_goes_on(self):
        class Enough(Exception):
            pass

        reason = Enough("at tick 100")
        wanted = []

        def hand(tick, pose, force):
            if tick == 100 and not wanted:
                wanted.append(tick)
                raise reason

        session = tactus.Session(bench.scene("press"), hand=hand)
        with self.assertRaises(Enough) as caught:
            session.step(500)
        self.assertIs(caught.exception, reason)
        self.assertEqual(session.ticks, 101)
        session.step(99)
        self.assertEqual(session.ticks, 200)
        self.assertEqual(session.last["fault"], 0)

    def test_a_hand_cannot_step_its_own_session(self):
        session = tactus.Session(bench.scene("press"), hand=lambda tick, pose, force: session.step(1))
        with self.assertRaisesRegex(tactus.UseError, "one call at a time"):
            session.step(10)

    def test_what_is_no_target_is_one_line(self):
        for target, said in (([1, 2], "2 numbers"), ([[1, 2, 3]], "2 dimensions"), ([0, 0, float("nan")], "not finite"),
                             ([0, 0, 0, 0, 0, 0, 0], "rotation is 0"), ("up", "no target"), (object(), "no target"),
                             (np.array([1j, 0, 0]), "no target"), ([1 + 2j, 0, 0], "no target"), ([0] * 8, "8 numbers"),
                             ([0, 0, 0, 0, 0, float("inf")], "wrench is not finite")):
            session = tactus.Session(bench.scene("press"), hand=lambda tick, pose, force, target=target: target)
            with self.assertRaisesRegex(tactus.OptionError, said) as caught:
                session.step(3)
            self.assertNotIn("\n", str(caught.exception))
        session = tactus.Session(bench.scene("press"), hand="targets")
        for targets, said in ((np.zeros((5, 4)), r"shape \(5, 4\)"), (np.zeros(3), r"shape \(3\)"),
                              (np.full((2, 3), np.inf), "not finite"), ("abc", "no target"),
                              (np.full((2, 6), np.nan), "not finite"), (np.zeros((2, 3), complex), "no target")):
            with self.assertRaisesRegex(tactus.OptionError, said):
                session.step(targets)
        self.assertEqual(session.ticks, 0)

    def test_the_cost_of_a_hand_is_said(self):
        start = tactus.Session(bench.scene("card_house")).position[0].copy()
        targets = np.tile(start, (2000, 1))
        took = {}
        for name, hand, ticks in (("without", None, 2000), ("function", lambda tick, pose, force: start, 2000),
                                  ("block", "targets", targets)):
            session = tactus.Session(bench.scene("card_house"), hand=hand)
            began = time.perf_counter()
            session.step(ticks)
            took[name] = (time.perf_counter() - began) / 2000 * 1e6
            self.assertEqual(session.ticks, 2000)
        print("a tick of the card house, us: " + ", ".join(f"{name} {us:.1f}" for name, us in took.items()))


class Mistakes(unittest.TestCase):
    def test_options(self):
        for options, said in (({"coupling": "stattic"}, "coupling: 'stattic' is none; accepted: sub-world"),
                              ({"couplin": "static"}, "couplin: no such option, did you mean coupling?"),
                              ({"ratio": "many"}, "ratio: 'many' is not accepted; accepted: a whole number"),
                              ({"ratio": -1}, "accepted: a whole number"), ({"rate_Hz": float("nan")}, "rate_Hz"),
                              ({"rate_Hz": 0.0}, "rate_Hz"), ({"hand": 3}, "hand: 3 is no hand"),
                              ({"history_ticks": 0}, "history_ticks"), ({"world_cpus": 3}, "a list of whole numbers")):
            with self.subTest(options=options), self.assertRaises(tactus.OptionError) as caught:
                tactus.Session(bench.scene("press"), **options)
            self.assertIn(said, str(caught.exception))
            self.assertNotIn("\n", str(caught.exception))

    def test_calls(self):
        session = tactus.Session(bench.scene("press"))
        with self.assertRaisesRegex(tactus.OptionError, "-3 ticks"):
            session.step(-3)
        with self.assertRaisesRegex(tactus.OptionError, "no request"):
            session.request("dance")
        with self.assertRaisesRegex(tactus.UseError, "hand=\"targets\""):
            session.step(np.zeros((3, 3)))
        with self.assertRaisesRegex(tactus.FileError, "nowhere"):
            session.record("/nowhere/a.tape")
        for wrong in (b"abc", None, 3):
            with self.assertRaisesRegex(tactus.OptionError, "accepted: what save"):
                session.restore(wrong)
        for wrong in (None, 3, "a\0b"):
            with self.assertRaisesRegex(tactus.OptionError, "is no path"):
                session.record(wrong)
        for wrong in (3, None, "\ud800"):
            with self.assertRaisesRegex(tactus.OptionError, "is no request"):
                session.request(wrong)
        saved = tactus.Session(bench.scene("press")).save()
        with self.assertRaisesRegex(tactus.UseError, "not of this session"):
            session.restore(saved)
        with self.assertRaises(tactus.FileError):
            tactus.Session("no/such/scene.toml")
        with session:
            session.step(5)
        with self.assertRaisesRegex(tactus.UseError, "not open"):
            session.step(5)
        self.assertEqual(len(session.position), len(session.bodies))
        self.assertTrue(issubclass(tactus.OptionError, (tactus.Error, ValueError)))

    def test_what_is_no_scene_is_one_line(self):
        deep = inner = {}
        for _ in range(100_000):
            inner["a"] = {}
            inner = inner["a"]
        cyclic = {}
        cyclic["a"] = cyclic
        good = {"effects": ["gravity"], "proxy": {"shape": "sphere", "radius_m": 0.01, "mass_kg": 0.2}, "body": [{"shape": "plane"}]}
        for scene, error, said in ((None, tactus.OptionError, "None is no scene"), ("a\udc80.toml", tactus.FileError, r"a\\x80"),
                                   ("a\0b", tactus.OptionError, "without NUL"), (b"a", tactus.OptionError, "is no scene"),
                                   ({**good, "x": deep}, tactus.FileError, "nested too deeply"),
                                   ({**good, "x": cyclic}, tactus.FileError, "within themselves"),
                                   ({**good, "title": "\ud800"}, tactus.FileError, "lone surrogates"),
                                   ({**good, "\ud800": 1}, tactus.FileError, "lone surrogates")):
            with self.subTest(said=said), self.assertRaisesRegex(error, said) as caught:
                tactus.Session(scene)
            self.assertNotIn("\n", str(caught.exception))
        while deep:  # without recursion
            deep = deep["a"]

    def test_an_object_without_its_init_raises(self):
        for make, use in ((tactus.Session, lambda o: o.step(1)), (tactus.Session, lambda o: o.position),
                          (tactus.Session, lambda o: o.ticks), (tactus.Session, lambda o: o.hands),
                          (tactus.Session, lambda o: o.replace(bench.scene("press"))), (tactus.SessionHand, lambda o: o.look()),
                          (tactus.Live, lambda o: o.look()), (tactus.Live, lambda o: o.state()), (tactus.Tape, lambda o: o["tick"]),
                          (tactus.Tape, lambda o: o.replay()),
                          (tactus.SavedState, lambda o: tactus.Session(bench.scene("press")).restore(o))):
            with self.subTest(make=make), self.assertRaisesRegex(tactus.UseError, "has no content") as caught:
                use(make.__new__(make))
            self.assertNotIn("\n", str(caught.exception))

    def test_a_tape_that_another_session_writes_is_refused_and_stays_whole(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "a.tape")
            first, second = tactus.Session(bench.scene("press")), tactus.Session(bench.scene("free"))
            first.record(path)
            first.step(300)
            with self.assertRaisesRegex(tactus.FileError, "another run is writing this tape"):
                second.record(path)
            program = bench.program("run", bench.scene("press"), "--virtual-time", "--duration", 0.1, "--record", path)
            self.assertIn("another run is writing this tape", program["error"])
            first.step(300)
            first.close()
            self.assertEqual((len(tactus.Tape(path)), tactus.Tape(path).damage), (600, ""))
            second.record(path)
            second.step(50)
            second.close()
            self.assertEqual(len(tactus.Tape(path)), 50)

    def test_replace_keeps_no_hand_and_no_options(self):
        session = tactus.Session(bench.scene("free"), hand=lambda tick, pose, force: None, coupling="static")
        session.replace(bench.scene("press"))
        session.step(300)
        plain = tactus.Session(bench.scene("press"))
        plain.step(300)
        self.assertEqual(session.state_hash, plain.state_hash)
        self.assertIn("none is kept", " ".join(tactus.Session.replace.__doc__.split()))

    @long
    def test_a_million_steps_grow_nothing(self):
        session = tactus.Session(bench.scene("free"), history_ticks=100)
        views = session.position
        session.step(20000)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for _ in range(1000):
            session.step(1000)
            self.assertEqual(session.position.shape, views.shape)
        grown_kB = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
        print(f"1,000,000 steps: {grown_kB} kB more")
        self.assertLess(grown_kB, 1024)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=1)
