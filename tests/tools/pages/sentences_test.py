#!/usr/bin/python3
"""Numbers, ticks and the sentences that pages open with: true of their data, and said where data is missing."""
import os
import sys
import unittest

sys.dont_write_bytecode = True
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.join(HERE, "..", "..", "..", "tools")]
try:
    import matplotlib
    matplotlib.use("svg")
except ImportError:
    print("tactus-skipped: no matplotlib (Debian: python3-matplotlib)")
    sys.exit(77)
import made
from pages import accuracy_cost, capacity, couplings, engines, figure, numbers, random_worlds, stability

NAN = float("nan")


class Numbers(unittest.TestCase):
    def test_three_digits_and_no_more(self):
        for value, words in ((0, "0"), (0.0123456, "0.0123"), (0.99951, "1.00"), (12.3456, "12.3"), (999.6, "1000"),
                             (12345, "12\u202f300"), (-2.5, "−2.50"), (3.14927889e10, "3.15·10¹⁰"), (4.2e-7, "4.20·10⁻⁷"),
                             (NAN, "n/a"), (None, "n/a"), (float("inf"), "n/a")):
            self.assertEqual(numbers.number(value), words)

    def test_shares_become_multiples_where_per_cent_say_nothing(self):
        for value, words in ((0, "0 %"), (0.00001, "< 0.01 %"), (0.00123, "0.12 %"), (0.5, "50.0 %"), (9.9, "990 %"),
                             (12.34, "12.3×"), (314927889.7107, "over 1000×"), (-0.00001, "> −0.01 %"), (None, "n/a")):
            self.assertEqual(numbers.share(value), words)

    def test_differences_have_a_sign_and_are_rounded(self):
        for value, words in ((0.034, "+3.40 points"), (-0.5, "−50.0 points"), (3e8, "+3.00·10¹⁰ points"), (1e-6, "about 0"), (0, "0"), (None, "n/a")):
            self.assertEqual(numbers.points(value), words)
        for value, words in ((5.4567, "+5.46"), (-0.0163, "−0.02"), (0.001, "0"), (-48.71, "−48.7"), (None, "n/a")):
            self.assertEqual(numbers.micro(value), words)

    def test_chosen_numbers_keep_their_digits(self):
        for value, words in ((1000, "1000"), (0.5, "0.5"), (100.0, "100"), (12500, "12\u202f500")):
            self.assertEqual(numbers.exact(value), words)


class Axes(unittest.TestCase):
    def test_every_span_has_three_to_eight_ticks(self):
        for low in (1e-9, 0.02, 1, 7.3, 600):
            for high in (5 * low, 37 * low, 1e4 * low, 1e12 * low):
                scale = figure.Scale([low, high], far=1e15)
                ticks = figure.log_ticks(scale.low, scale.high, 8)
                self.assertTrue(3 <= len(ticks) <= 8, (low, high, ticks))
                self.assertEqual(ticks, sorted(ticks))

    def test_what_is_far_off_is_off_the_scale_and_the_rest_is_not(self):
        scale = figure.Scale([1.0, 2.0, 3.0, 3e9])
        self.assertTrue(scale.place(3e9)[1])
        self.assertFalse(any(scale.place(v)[1] for v in (1.0, 2.0, 3.0)))
        self.assertLess(scale.high, 10)

    def test_what_is_below_the_floor_lies_on_it(self):
        scale = figure.Scale([1e-9, 0.0, -4.0, 1.0], floor=0.01)
        self.assertEqual([scale.place(v) for v in (1e-9, 0.0, -4.0)], [(0.01, False)] * 3)

    def test_no_number_has_no_place(self):
        scale = figure.Scale([1.0, NAN, None])
        self.assertIsNone(scale.place(NAN)[0])
        self.assertIsNone(scale.place(None)[0])


def coupling_answer(data, what):
    windows = couplings.Windows(data)
    return couplings.answer(windows, windows.sentences()[0], what)


class Sentences(unittest.TestCase):
    def test_energy_loss_names_the_worst_scene_of_our_border(self):
        data = made.windows(["stack", "pile"], made.COUPLINGS[:2], [2, 8])
        for row in data["rows"]:
            if row["border"] == "ghost" and row["ratio"] == 8:
                row.update(force_error_rms=0.031 if row["scene"] == "pile" else 0.01, loss=0.0, gain=0.002)
        words = coupling_answer(data, "energy-loss")
        self.assertIn("At ratio 8", words)
        self.assertIn("at most 3.10 % (pile)", words)
        self.assertIn("loses none", words)
        self.assertIn("stable on all scenes", words)

    def test_couplings_are_sorted_by_their_worst_scene(self):
        data = made.windows(["stack"], [("static", "-"), ("plane", "-")], [8])
        for row in data["rows"]:
            row.update(force_error_rms={"static": 0.3, "plane": 0.2}.get(row["coupling"], 0.0), stable=row["coupling"] != "plane")
        words = coupling_answer(data, "couplings")
        self.assertLess(words.index("plane"), words.index("static"))
        self.assertTrue(words.endswith("stable on all scenes: static."))

    def test_no_number_is_worse_than_any(self):
        data = made.windows(["stack", "pile"], made.COUPLINGS[:1], [8])
        data["rows"][-1]["force_error_rms"] = None
        self.assertIn("an unknown amount (pile)", coupling_answer(data, "energy-loss"))

    def test_no_coupling_is_said(self):
        self.assertIn("Nothing can be compared", coupling_answer(made.windows(["stack"], [], []), "couplings"))

    def cost_answer(self, data):
        return accuracy_cost.answer([accuracy_cost.Scene(s, data) for s in dict.fromkeys(p["scene"] for p in data["points"])], data)

    def test_cost_of_half_the_error_is_that_of_the_cheapest_that_has_it(self):
        data = made.costs(("stack",))
        # The default: 2 % in 10.12 us. Of those with 1 % or less the first takes 15.12 us.
        words = self.cost_answer(data)
        self.assertIn("changes the median tick by +5.00 µs (stack)", words)
        self.assertIn("10.1 µs (stack) of the 600 µs", words)
        self.assertIn("below the 7 %", words)

    def test_an_error_that_a_hand_notices_is_said(self):
        data = made.costs(("stack", "pile"))
        for point in data["points"]:
            if point["scene"] == "pile":
                point["force_error_rms"] = 0.08
        words = self.cost_answer(data)
        self.assertIn("beyond the 7 % that a hand notices on pile", words)
        self.assertIn("cannot be done by any measured setting on pile", words)

    def test_a_default_without_a_number_is_said(self):
        data = made.costs(("stack",))
        data["points"][0]["force_error_rms"] = None
        self.assertIn("not known", self.cost_answer(data))

    def test_changes_are_sorted_by_what_they_save(self):
        scene = accuracy_cost.Scene("stack", made.awkward_costs())
        changes = [accuracy_cost.change_of_error(n) for n in scene.notches]
        self.assertEqual(changes, sorted(changes))

    def test_capacity_says_whether_the_end_was_found(self):
        data = made.capacity()
        self.assertIn("1000 cubes at 1000 Hz and ratio 10, 10.0 times the 100", capacity.answer(data))
        self.assertIn("at 1200 its global step is too slow", capacity.answer(data))
        for row in data["rows"]:
            row.update(too_many=None)
        self.assertIn("no larger heap was tried", capacity.answer(data))
        self.assertIn("not even the smallest heap, 25", capacity.answer(made.awkward_capacity()))

    def test_stability_says_what_is_not_safe(self):
        self.assertIn("1430 N/m with 5.27 N s/m", stability.answer(made.stability()))
        self.assertIn("none of the 20 measured", stability.answer(made.stability()))
        self.assertIn("No gains can be given", stability.answer(made.awkward_stability()))
        self.assertIn("2 of the 20 measured boundaries LIE BELOW", stability.answer(made.awkward_stability()))

    def test_peers_counts_the_scenes_on_which_tactus_is_faster(self):
        data = made.peers()
        data["rows"][5]["ratio_to_best_peer"] = 1.25
        self.assertIn("0.500 times (pile64) to 1.25 times (pile1000-stirred)", engines.answer(data["rows"]))
        self.assertIn("faster on 1 of 2", engines.answer(data["rows"]))
        self.assertIn("not compared: pile64", engines.answer(made.awkward_peers()["rows"]))
        self.assertIn("No time of tactus can be compared", engines.answer(data["rows"][1:5]))

    def test_random_worlds_are_counted_without_those_left_out(self):
        self.assertIn("1 of 19 random worlds collapses", random_worlds.answer(made.random_worlds()))
        self.assertIn("No random world was tried", random_worlds.answer({**made.random_worlds(), "worlds": 1}))


if __name__ == "__main__":
    unittest.main()
