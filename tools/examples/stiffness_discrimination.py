#!/usr/bin/python3
"""A study: by how much must a surface be stiffer to feel stiffer? Two intervals, 1-up-2-down.

  stiffness_discrimination.py --simulated --seeds 20           a simulated participant, many times
  stiffness_discrimination.py --folder anna --device usb       a person; the same command goes on after a break

In a trial the hand presses on two surfaces, one of the reference's stiffness and one stiffer, in random order, and says
which was stiffer. Two right answers in a row make the difference smaller, a wrong one larger; the threshold, where 70.7 %
are right, is fitted to all answers (maximum likelihood, of a participant whose answers are Gaussian in the difference).
The folder gets a row a trial (trials.csv) and a tape an interval. The order is the seed's: a study that was broken off
goes on as if it had not been. Needs tactus (PYTHONPATH=build/release/python in a build folder) and NumPy.
"""
import argparse
import csv
import math
import os
import statistics
import subprocess
import sys
import tempfile

import numpy as np
import tactus

REFERENCE_N_PER_M = 400.0
STEPS = (0.08, 0.04, 0.02)         # of the difference, relative; the last one stays
START, LEAST = 0.3, 0.01
REVERSALS = 28                     # the first 4 with the large steps; about 95 trials
NOISE = 0.08                       # of the simulated participant: standard deviation of a felt stiffness, relative
NORMAL = statistics.NormalDist()
RIGHT = math.sqrt(0.5)             # 70.7 %, where 1-up-2-down settles
TRUE = NORMAL.inv_cdf(RIGHT) * math.sqrt(2) * NOISE
COLUMNS = ["trial", "difference", "stiffer_interval", "answer", "right", "seed"]


def scene_of(stiffness_N_per_m):
    touch_m = 0.11  # the fingertip's centre when it touches the surface
    return {
        "title": "Press on a surface",
        "effects": ["friction"],
        "device": {"position_m": [0, 0, touch_m]},
        "coupling": {"stiffness_N_per_m": stiffness_N_per_m, "damping_Ns_per_m": 5, "stiffness_Nm_per_rad": 4,
                     "damping_Nms_per_rad": 0.02},
        "proxy": {"shape": "sphere", "radius_m": 0.01, "mass_kg": 0.1, "position_m": [0, 0, touch_m + 0.002]},
        "body": [{"shape": "box", "size_m": [0.2, 0.2, 0.1], "fixed": True, "position_m": [0, 0, 0.05]}],
        "hand": {"repeat": False, "path": [{"time_s": 0, "position_m": [0, 0, touch_m + 0.002]},
                                           {"time_s": 0.3, "position_m": [0, 0, touch_m - 0.01]},
                                           {"time_s": 0.5, "position_m": [0, 0, touch_m - 0.01]}]},
    }


class Simulated:
    """Feels the slope of force over the tool's way into the surface, with noise; a surface is pressed once and kept."""

    def __init__(self, seed):
        self.seed, self.felt = seed, {}

    def interval(self, trial, interval, stiffness_N_per_m, tape):
        if tape or stiffness_N_per_m not in self.felt:
            session = tactus.Session(scene_of(stiffness_N_per_m))
            if tape:
                session.record(tape)
            session.step(500)
            session.close()
            ticks = session.look()[300:]  # pressed and at rest
            way_m = ticks["proxy_position_m"][:, 2] - ticks["target_position_m"][:, 2]
            self.felt[stiffness_N_per_m] = float(ticks["force_N"][:, 2] @ way_m / (way_m @ way_m))
        noise = np.random.default_rng([self.seed, 1, trial, interval])  # the same after a break
        return self.felt[stiffness_N_per_m] + noise.normal(0, NOISE * REFERENCE_N_PER_M)

    def answer(self, felt):
        return 1 if felt[0] > felt[1] else 2


class Person:
    """At a device, in real time: `tactus run` presents an interval, the keyboard has the answer."""

    def __init__(self, device):
        self.device = device

    def interval(self, trial, interval, stiffness_N_per_m, tape):
        with tempfile.TemporaryDirectory() as folder:
            scene = os.path.join(folder, "surface.toml")
            tactus.Scene(scene_of(stiffness_N_per_m)).save(scene)
            input(f"Trial {trial + 1}, interval {interval}: Enter begins it ")
            subprocess.run(["tactus", "run", scene, "--device", self.device, "--duration", "5", "--record", tape],
                           check=True, stdout=subprocess.DEVNULL)
        return None

    def answer(self, felt):
        while (key := input("Which was stiffer, 1 or 2? ")) not in ("1", "2"):
            pass
        return int(key)


class Staircase:
    """The difference of the next trial, from the answers so far."""

    def __init__(self):
        self.difference, self.in_a_row, self.last_move, self.reversals = START, 0, 0, 0

    def take(self, right):
        self.in_a_row = self.in_a_row + 1 if right else 0
        move = -1 if self.in_a_row == 2 else 0 if right else 1
        if move == 0:
            return
        self.in_a_row = 0
        self.reversals += self.last_move == -move
        self.last_move = move
        step = STEPS[min(self.reversals // 2, len(STEPS) - 1)]
        self.difference = round(max(self.difference + move * step, LEAST), 6)


def study(seed, participant, folder):
    """All trials, those in the folder first; ends by the number of reversals."""
    rows = read_rows(folder)
    for row in rows:
        if row[5] != seed:
            raise tactus.OptionError(f"--folder {folder}: its study has seed {row[5]}, and so another order; accepted: --seed "
                                     f"{row[5]}, or another folder")
    stairs, order = Staircase(), np.random.default_rng([seed, 0])
    for trial in range(10_000):
        stiffer = int(order.integers(1, 3))
        if stairs.reversals >= REVERSALS:
            return rows
        if trial >= len(rows):
            felt = []
            for interval in (1, 2):
                stiffness = REFERENCE_N_PER_M * (1 + (stairs.difference if interval == stiffer else 0))
                tape = os.path.join(folder, f"trial{trial:04}-{interval}.tape") if folder else None
                felt.append(participant.interval(trial, interval, stiffness, tape))
            answer = participant.answer(felt)
            rows.append([trial, stairs.difference, stiffer, answer, int(answer == stiffer), seed])
            write_row(folder, rows[-1])
        stairs.take(rows[trial][4] == 1)
    return rows


def read_rows(folder):
    path = os.path.join(folder or "", "trials.csv")
    if not folder or not os.path.exists(path):
        return []
    with open(path, "r+", newline="", encoding="utf-8") as file:
        text = file.read()
        whole = text[:text.rfind("\n") + 1]  # a break may have left half a row
        file.truncate(len(whole.encode()))
    header, *rows = list(csv.reader(whole.splitlines())) or [COLUMNS]
    try:
        if header != COLUMNS or any(len(row) != len(COLUMNS) for row in rows):
            raise ValueError
        return [[int(row[0]), float(row[1]), *map(int, row[2:])] for row in rows]
    except ValueError:
        raise tactus.FileError(f"{path}: is no table of this study; accepted: the columns {', '.join(COLUMNS)}") from None


def write_row(folder, row):
    if not folder:
        return
    path = os.path.join(folder, "trials.csv")
    new = not os.path.exists(path) or os.path.getsize(path) == 0
    with open(path, "a", newline="", encoding="utf-8") as file:
        rows = csv.writer(file)
        if new:
            rows.writerow(COLUMNS)
        rows.writerow(row)


def threshold_of(rows):
    """The most likely difference at which 70.7 % of the answers are right."""
    candidates = np.geomspace(0.005, 1, 400)
    score = np.zeros(len(candidates))
    for _, difference, _, _, right, _ in rows:
        p = [min(NORMAL.cdf(NORMAL.inv_cdf(RIGHT) * difference / at), 1 - 1e-9) for at in candidates]
        score += np.log(p) if right else np.log1p(-np.array(p))
    return float(candidates[score.argmax()])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--simulated", action="store_true", help="a simulated participant")
    parser.add_argument("--seeds", type=int, default=1, help="studies of the simulated participant (default: 1)")
    parser.add_argument("--seed", type=int, default=1, help="of the order, and the first of --seeds (default: 1)")
    parser.add_argument("--folder", help="rows and tapes; a study that is there goes on")
    parser.add_argument("--device", default="sim", help="as of tactus run, for a person (default: sim)")
    arguments = parser.parse_args()
    if arguments.folder:
        os.makedirs(arguments.folder, exist_ok=True)
    elif not arguments.simulated:
        parser.error("a person's study is kept: --folder FOLDER")
    if not arguments.simulated or arguments.folder:
        participant = Simulated(arguments.seed) if arguments.simulated else Person(arguments.device)
        rows = study(arguments.seed, participant, arguments.folder)
        print(f"{len(rows)} trials, threshold {100 * threshold_of(rows):.1f} %")
        return
    felt, thresholds = {}, []
    for seed in range(arguments.seed, arguments.seed + arguments.seeds):
        participant = Simulated(seed)
        participant.felt = felt
        thresholds.append(threshold_of(study(seed, participant, None)))
    print(f"{arguments.seeds} studies: threshold {100 * np.mean(thresholds):.2f} % (standard deviation "
          f"{100 * np.std(thresholds):.2f} %), true {100 * TRUE:.2f} %, ratio {np.mean(thresholds) / TRUE:.3f}")


if __name__ == "__main__":
    try:
        main()
    except (EOFError, KeyboardInterrupt):
        sys.exit("\nstiffness_discrimination: broken off; the same command goes on")
    except tactus.Error as error:
        sys.exit(f"stiffness_discrimination: {error}")
