#!/usr/bin/python3
"""tests/tools/python/gym_test.py PROGRAM FOLDER: tactus.gym.TouchEnv. Where gymnasium is missing, as in Debian, a stand-in has
the few parts that it uses, and the test says so."""
import os
import subprocess
import sys
import unittest

import bench
import numpy as np
import tactus

from gymnasium_here import HAS_GYMNASIUM

from tactus.gym import TouchEnv


def episode(env, seed, steps=60):
    """Down for half a second: all that is observed."""
    seen = [env.reset(seed=seed)[0]]
    for _ in range(steps):
        observation, _, terminated, _, _ = env.step([0, 0, -1])
        seen.append(observation)
        if terminated:
            break
    return seen


class Touch(unittest.TestCase):
    def setUp(self):
        self.env = TouchEnv(bench.scene("press"), watch=["body 1", 2])
        self.addCleanup(self.env.close)

    def test_spaces_hold_what_comes(self):
        for observation in episode(self.env, 1):
            self.assertTrue(self.env.observation_space.contains(observation))
        if HAS_GYMNASIUM:
            from gymnasium.utils.env_checker import check_env
            check_env(self.env, skip_render_check=True)

    def test_the_target_follows_the_action_and_stays_within_reach(self):
        start = self.env.reset(seed=1)[0]["target"]
        moved = self.env.step([0.5, 0, -1])[0]["target"]
        np.testing.assert_allclose(moved[:3] - start[:3], [0.001, 0, -0.002], atol=1e-12)  # 0.2 m/s, 10 ms
        np.testing.assert_array_equal(moved[3:], start[3:])
        for _ in range(60):
            far = self.env.step([1, 0, 0])[0]["target"]
        self.assertAlmostEqual(far[0], start[0] + 0.1)

    def test_the_hand_feels_what_it_presses_on(self):
        seen = episode(self.env, 1)
        self.assertLess(abs(seen[0]["force"][2]), 0.01)  # it hangs in the air
        self.assertGreater(max(observation["force"][2] for observation in seen), 1.0)
        self.assertLess(seen[-1]["tool"][2], seen[0]["tool"][2])

    def test_same_seed_and_actions_give_the_same_bits(self):
        first, second = episode(self.env, 7), episode(self.env, 7)
        for a, b in zip(first, second, strict=True):
            for key in a:
                np.testing.assert_array_equal(a[key], b[key])

    def test_a_target_turns(self):
        env = TouchEnv(bench.scene("press"), turn_rad_per_s=1.0, ticks=100)
        env.reset(seed=1)
        for _ in range(3):
            observation = env.step([0, 0, 0, 0, 1, 0])[0]
        half = 0.15  # 0.3 rad about y
        np.testing.assert_allclose(np.abs(observation["target"][3:]), [np.cos(half), 0, np.sin(half), 0], atol=1e-3)
        self.assertEqual(env.action_space.shape, (6,))

    def test_rewards_ends_and_scenes_are_the_users(self):
        scene = tactus.Scene(bench.scene("press"))
        masses = []

        def vary(random):
            scene["proxy"]["mass_kg"] = float(random.uniform(0.1, 0.3))
            masses.append(scene["proxy"]["mass_kg"])
            return scene

        def reward(observation, action, info):
            return -observation["force"][2], observation["force"][2] > 1.0

        env = TouchEnv(scene, vary=vary, reward=reward, duration_s=0.2)
        env.reset(seed=3)
        env.reset(seed=3)
        env.reset()
        self.assertEqual(masses[0], masses[1])
        self.assertNotEqual(masses[1], masses[2])
        ends, truncations = [], []
        for _ in range(60):
            observation, got, terminated, truncated, info = env.step([0, 0, -1])
            self.assertEqual(got, -observation["force"][2])
            ends.append(terminated)
            truncations.append(truncated)
        self.assertTrue(any(ends))
        self.assertFalse(ends[0])
        self.assertEqual(truncations.index(True), 19)  # a tick to begin, then 10 a step

    def test_mistakes_are_one_line(self):
        for wrong in ({"watch": ["no body"]}, {"watch": [10**6]}, {"ticks": 0}, {"ticks": 1.5}, {"reach_m": -1},
                      {"turn_rad_per_s": 0}, {"duration_s": float("nan")}, {"coupling": "none"}):
            with self.subTest(wrong=wrong), self.assertRaises(tactus.OptionError) as raised:
                TouchEnv(bench.scene("press"), **wrong)
            self.assertNotIn("\n", str(raised.exception))
        for action in ([0, 0], [0, 0, float("nan")], [[0, 0, 0]]):
            with self.subTest(action=action), self.assertRaises(tactus.OptionError):
                self.env.step(action)

    @unittest.skipIf(HAS_GYMNASIUM, "gymnasium is there")
    def test_its_absence_is_one_line(self):
        made = subprocess.run([sys.executable, "-c", "import tactus\ntry:\n  import tactus.gym\nexcept tactus.MachineError as e:\n  print(e)"],
                              capture_output=True, text=True, check=True, env={**os.environ, "PYTHONPATH": bench.MODULE})
        self.assertIn("gymnasium is missing", made.stdout)
        self.assertEqual(made.stdout.count("\n"), 1)


if __name__ == "__main__":
    if not HAS_GYMNASIUM:
        print("gymnasium is missing: a stand-in takes its place")
    unittest.main(argv=sys.argv[:1] + sys.argv[3:], verbosity=1)
