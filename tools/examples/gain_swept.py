#!/usr/bin/python3
"""What the hand feels of a pressed block, for one coupling stiffness after the other: gain_swept.py SCENE.toml

The same as a sweep, for many more runs and on several cores: tactus sweep gains.toml. Needs tactus
(PYTHONPATH=build/release/python in a build folder).
"""
import argparse
import sys

import numpy as np
import tactus


def force_at(scene, stiffness_N_per_m, seconds):
    changed = tactus.Scene(scene)
    changed["coupling"]["stiffness_N_per_m"] = stiffness_N_per_m
    with tactus.Session(changed, history_ticks=100_000) as session:
        session.step(round(seconds / session.period_s))
        ticks = session.look()
    return np.linalg.norm(ticks["force_N"], axis=1), ticks["deepest_overlap_m"]


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("scene", help="such as sim/scenes/press.toml")
    parser.add_argument("--gains", type=float, nargs="+", default=[250, 500, 1000, 1500], help="N/m")
    parser.add_argument("--seconds", type=float, default=2, help="of simulated time, at most 100")
    arguments = parser.parse_args()
    print("stiffness [N/m]  force rms [N]  force max [N]  deepest overlap [um]")
    for gain in arguments.gains:
        try:
            force, overlap = force_at(arguments.scene, gain, arguments.seconds)
        except tactus.Error as error:  # such as a gain that is not stable with this device
            sys.exit(f"gain_swept: {error}")
        print(f"{gain:15.0f}  {np.sqrt(np.mean(force**2)):13.3f}  {force.max():13.3f}  {1e6 * overlap.max():20.1f}")


if __name__ == "__main__":
    main()
