#!/usr/bin/python3
"""A hand that draws a circle on a board and presses with a constant force, by an integrator: circle_hand.py

Prints how well radius and force were kept. Needs tactus (PYTHONPATH=build/release/python in a build folder).
"""
import argparse

import numpy as np
import tactus

BOARD_M = 0.1      # height of the board's upper side
RADIUS_M = 0.01    # of the fingertip
SCENE = {
    "title": "A fingertip above a board",
    "effects": ["gravity", "friction"],
    "device": {"position_m": [0, 0, BOARD_M]},
    "coupling": {"stiffness_N_per_m": 1500, "damping_Ns_per_m": 5, "stiffness_Nm_per_rad": 4, "damping_Nms_per_rad": 0.02},
    "proxy": {"shape": "sphere", "radius_m": RADIUS_M, "mass_kg": 0.2, "friction": 0.2,
              "position_m": [0.03, 0, BOARD_M + RADIUS_M + 0.005]},
    "body": [{"shape": "box", "size_m": [0.3, 0.3, 0.02], "fixed": True, "friction": 0.2,
              "position_m": [0, 0, BOARD_M - 0.01]}],
    "hand": {"path": [{"time_s": 0, "position_m": [0.03, 0, BOARD_M + RADIUS_M + 0.005]}]},
}


class Draw:
    """The function that a session asks: where the hand wants the tool at this tick."""

    def __init__(self, force_N, radius_m, period_s, round_s):
        self.force_N, self.radius_m, self.period_s, self.round_s = force_N, radius_m, period_s, round_s
        self.height_m = BOARD_M + RADIUS_M + 0.005

    def __call__(self, tick, tool_pose, force):
        # The board pushes up what the hand presses down: down while it is too little.
        error_N = self.force_N - force[2]
        self.height_m -= np.clip(0.02 * error_N, -0.05, 0.05) * self.period_s
        angle = 2 * np.pi * max(0.0, tick * self.period_s - 1.0) / self.round_s
        return [self.radius_m * np.cos(angle), self.radius_m * np.sin(angle), self.height_m]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--force", type=float, default=2.0, help="N")
    parser.add_argument("--radius", type=float, default=0.03, help="m")
    parser.add_argument("--record", help="write a tape here")
    arguments = parser.parse_args()
    hand = Draw(arguments.force, arguments.radius, 1e-3, 4.0)
    session = tactus.Session(SCENE, hand=hand, history_ticks=10_000)
    if arguments.record:
        session.record(arguments.record)
    session.step(5000)  # a second to settle, then a round
    session.close()
    ticks = session.look()[1000:]
    radius = np.hypot(*ticks["proxy_position_m"][:, :2].T)
    force = ticks["force_N"][:, 2]
    turned = np.unwrap(np.arctan2(ticks["proxy_position_m"][:, 1], ticks["proxy_position_m"][:, 0]))
    print(f"angle {np.degrees(turned[-1] - turned[0]):.1f} deg, radius {1e3 * radius.mean():.2f} mm "
          f"(rms error {1e3 * np.sqrt(np.mean((radius - arguments.radius)**2)):.2f} mm), force {force.mean():.3f} N "
          f"(rms error {np.sqrt(np.mean((force - arguments.force)**2)):.3f} N)")


if __name__ == "__main__":
    main()
