#!/usr/bin/python3
"""tests/tools/python/hands_test.py PROGRAM FOLDER: tactus.Session with several hands against the program, and each hand's part."""
import os
import sys
import tempfile
import unittest

import bench
import numpy as np
import tactus

TWO_HANDS = os.path.join(bench.SOURCE, "tools", "examples", "two_hands.toml")


def program(seconds, *options):
    """The hands' objects of the program's report."""
    return bench.program("run", TWO_HANDS, "--virtual-time", "--duration", seconds, *options)["hands"]


def hashes(session):
    return [hand.state_hash for hand in session.hands]


def hashes_twice(session, ticks):
    """After so many ticks, and after the same ticks from the state that was restored."""
    saved = session.save()
    session.step(ticks)
    first = hashes(session)
    session.restore(saved)
    session.step(ticks)
    return first, hashes(session)


class Bits(unittest.TestCase):
    def test_each_hand_has_the_programs_bits(self):
        session = tactus.Session(TWO_HANDS)
        session.step(300)
        session.step(900)
        self.assertEqual(hashes(session), [hand["state_hash"] for hand in program(1.2)])
        self.assertNotEqual(*hashes(session))

    def test_injected_faults_are_of_their_hand(self):
        session = tactus.Session(TWO_HANDS, inject=["nan@900+2", "estop@500"], ratio=4)
        session.step(1000)
        report = program(1, "--inject", "nan@900+2", "--inject", "estop@500", "--ratio", 4)
        self.assertEqual(hashes(session), [hand["state_hash"] for hand in report])
        for hand, of_program in zip(session.hands, report):
            self.assertEqual(hand.summary()["faults"], of_program["faults"])
            self.assertEqual(hand.summary()["number"], of_program["number"])
        faults = session.hands[1].look()["fault"]
        self.assertEqual((faults[499], faults[-1]), (0, 11))
        self.assertFalse(session.hands[0].look()["fault"].any())
        self.assertTrue((session.hands[1].last["force_N"] == 0).all())
        session.hands[1].request("rearm")
        session.step(400)
        self.assertEqual(session.hands[1].last["fault"], 0)

    def test_a_saved_state_and_a_reset_give_the_same_bits(self):
        session = tactus.Session(TWO_HANDS)
        session.step(1237)
        expected, again = hashes_twice(session, 600)
        self.assertEqual(again, expected)
        session.reset()
        self.assertEqual([len(hand.look()) for hand in session.hands], [0, 0])
        session.step(1837)
        self.assertEqual(hashes(session), expected)

    def test_each_hand_has_a_tape(self):
        with tempfile.TemporaryDirectory() as folder:
            session = tactus.Session(TWO_HANDS)
            session.record(os.path.join(folder, "my.tape"))
            session.step(400)
            ticks = [hand.look() for hand in session.hands]
            session.close()
            for of_hand, name in zip(ticks, ("my.tape", "my.2.tape")):
                tape = tactus.Tape(os.path.join(folder, name))
                self.assertTrue(tape.replay().same_bits)
                self.assertTrue(np.array_equal(tape["force_x_N"], of_hand["force_N"][:, 0]))


class Hands(unittest.TestCase):
    def test_the_session_itself_has_the_first_hands_part(self):
        session = tactus.Session(TWO_HANDS)
        session.step(800)
        first, second = session.hands
        self.assertEqual((first.number, second.number), (0, 1))
        self.assertEqual(session.state_hash, first.state_hash)
        self.assertEqual(session.last, first.last)
        self.assertTrue(np.array_equal(session.members, first.members))
        self.assertTrue(np.array_equal(session.roles, first.roles))
        self.assertEqual(session.summary(), first.summary())
        self.assertIn("hand 2 of 2", second.summary_text)
        self.assertEqual(len(session.look()), 800)
        self.assertEqual(len(first.look()), 0)
        self.assertEqual(len(second.look()), 800)
        one = tactus.Session(bench.scene("press"))
        self.assertEqual(len(one.hands), 1)

    def test_members_are_of_one_hand(self):
        session = tactus.Session(TWO_HANDS)
        proxies = tactus.Scene(TWO_HANDS).checked().proxies
        self.assertEqual(proxies, [0, 1])
        held = 0
        for _ in range(30):
            session.step(50)
            members = [set(hand.members) for hand in session.hands]
            self.assertFalse(members[0] & members[1])
            for hand, of_hand, proxy in zip(session.hands, members, proxies):
                self.assertIn(proxy, of_hand)
                self.assertEqual(len(of_hand), hand.last["members"])
                self.assertTrue((hand.roles[sorted(of_hand)] >= 4).all())
                self.assertEqual((hand.roles >= 4).sum(), len(of_hand))
                self.assertTrue(np.array_equal(session.position[proxy], hand.last["proxy_position_m"]))
                held += len(of_hand) > 1
        self.assertGreater(held, 0)
        self.assertEqual(session.bodies[1]["name"], "proxy2")

    def test_views_are_read_only_and_follow(self):
        session = tactus.Session(TWO_HANDS)
        second = session.hands[1]
        roles = second.roles
        address = roles.__array_interface__["data"][0]
        with self.assertRaises(ValueError):
            roles[0] = 0
        session.step(700)
        self.assertEqual(second.roles.__array_interface__["data"][0], address)
        self.assertNotEqual(address, session.hands[0].roles.__array_interface__["data"][0])

    def test_a_hand_keeps_its_session_and_follows_a_replaced_scene(self):
        hand = tactus.Session(TWO_HANDS).hands[1]
        self.assertEqual(len(hand.members), 1)
        session = tactus.Session(TWO_HANDS)
        first, second = session.hands
        session.step(700)
        roles, members = second.roles, second.members
        session.replace(bench.scene("press"))
        self.assertTrue((roles == 255).all() and (members == 2**32 - 1).all())
        self.assertEqual(first.state_hash, session.state_hash)
        with self.assertRaisesRegex(tactus.UseError, r"hands\[1\]: the scene was replaced"):
            second.look()


class Led(unittest.TestCase):
    """Hands that Python leads."""

    def setUp(self):
        position = tactus.Session(TWO_HANDS).position
        self.starts = position[0].copy(), position[1].copy()

    def path(self, hand, ticks):
        start, sign = self.starts[hand], (1, -1)[hand]
        return start + np.outer(np.minimum(np.arange(ticks) / 500, 1), [0.012 * sign, 0, 0])

    def test_each_hand_is_led_by_its_function(self):
        asked = [[], []]
        paths = [self.path(hand, 1500) for hand in range(2)]

        def leader(number):
            def hand(tick, pose, force):
                asked[number].append((tick, pose[0], force[0]))
                return paths[number][tick]
            return hand

        session = tactus.Session(TWO_HANDS, hand=[leader(0), leader(1)])
        session.step(1500)
        for number in range(2):
            self.assertEqual([tick for tick, _, _ in asked[number]], list(range(1, 1500)))
        # Both press on the block between them, each from its side.
        self.assertLess(asked[0][-1][1], 0)
        self.assertGreater(asked[1][-1][1], 0)
        self.assertLess(asked[0][-1][2], -0.5)
        self.assertGreater(asked[1][-1][2], 0.5)
        blocks = tactus.Session(TWO_HANDS, hand=["targets", "targets"])
        blocks.step([path[:600] for path in paths])
        blocks.step(np.array(paths)[:, 600:])
        self.assertEqual(hashes(blocks), hashes(session))

    def test_the_scenes_script_leads_a_hand_that_python_does_not(self):
        targets = self.path(1, 800)
        session = tactus.Session(TWO_HANDS, hand=[None, "targets"])
        session.step([None, targets])
        expected, again = hashes_twice(session, 200)
        self.assertEqual(again, expected)
        by_function = tactus.Session(TWO_HANDS, hand=(None, lambda tick, pose, force: targets[min(tick, 799)]))
        by_function.step(1000)
        self.assertEqual(hashes(by_function), expected)
        scripted = tactus.Session(TWO_HANDS, inject=["unplugged@700", ""], hand=[None, "targets"])
        scripted.step([None, targets])
        self.assertEqual([hand.last["fault"] for hand in scripted.hands], [2, 0])

    def test_an_exception_of_a_hand_comes_out_and_the_session_goes_on(self):
        def hand(tick, pose, force):
            if tick == 50:
                raise KeyError("at tick 50")
            return None

        session = tactus.Session(TWO_HANDS, hand=[lambda tick, pose, force: None, hand])
        with self.assertRaisesRegex(KeyError, "at tick 50"):
            session.step(100)
        self.assertEqual(session.ticks, 51)
        session.step(10)
        self.assertEqual([hand.last["number"] for hand in session.hands], [60, 60])

    def test_mistakes_are_one_line_each(self):
        for hand, said in ((["targets"], "1 for 2 hands"), ("targets", "'targets' for 2 hands"),
                           ([None, 3], r"hand\[1\]: 3 is no hand"), ([None] * 3, "3 for 2 hands"),
                           (lambda tick, pose, force: None, "for 2 hands")):
            with self.subTest(hand=hand), self.assertRaisesRegex(tactus.OptionError, said) as caught:
                tactus.Session(TWO_HANDS, hand=hand)
            self.assertNotIn("\n", str(caught.exception))
        for inject, said in ((["", "", ""], "more_injects: 2"), (["", "nan@3"], r"hand\[1\]: is Python's"),
                             ([3], "text, or a list")):
            with self.subTest(inject=inject), self.assertRaisesRegex(tactus.OptionError, said):
                tactus.Session(TWO_HANDS, hand=[None, "targets"], inject=inject)
        with self.assertRaisesRegex(tactus.OptionError, "2 for 1 hands"):
            tactus.Session(bench.scene("press"), hand=[None, None])
        session = tactus.Session(TWO_HANDS, hand=[None, "targets"])
        for targets, said in ((np.zeros((5, 3)), "for 2 hands"), ([None, None], "targets of no hand"), ("up", "for 2 hands"),
                              ([None, np.zeros((5, 4))], r"shape \(5, 4\)")):
            with self.subTest(targets=targets), self.assertRaisesRegex(tactus.OptionError, said):
                session.step(targets)
        with self.assertRaisesRegex(tactus.UseError, "the hand is the scene's own"):
            session.step([np.zeros((5, 3)), None])
        both = tactus.Session(TWO_HANDS, hand=["targets", "targets"])
        with self.assertRaisesRegex(tactus.OptionError, "5 targets for one hand and 4 for another"):
            both.step([np.zeros((5, 3)), np.zeros((4, 3))])
        self.assertEqual((session.ticks, both.ticks), (0, 0))


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=1)
