#!/usr/bin/python3
"""Plots a tape's force and members over time, its cycles and faults: tape_to_plot.py my.tape -o my.svg

Needs tactus (PYTHONPATH=build/release/python in a build folder) and matplotlib (Debian: python3-matplotlib).
"""
import argparse
import sys

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt
import tactus


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tape", help="what `tactus run --record` or Session.record wrote")
    parser.add_argument("-o", "--out", default="tape.svg", help="the plot (default: %(default)s)")
    arguments = parser.parse_args()
    try:
        tape = tactus.Tape(arguments.tape)
    except tactus.Error as error:
        sys.exit(f"tape_to_plot: {error}")

    figure, (force, counts) = plt.subplots(2, sharex=True, figsize=(9, 5))
    for axis in "xyz":
        force.plot(tape["time_s"], tape[f"force_{axis}_N"], label=axis)
    force.set_ylabel("force on the hand [N]")
    force.legend()
    counts.step(tape["time_s"], tape["members"], label="members")
    counts.step(tape["time_s"], tape["contacts"], label="contacts")
    counts.set_xlabel("time [s]")
    counts.legend()
    for tick, _, words in tape.faults:
        force.axvline(tick * tape.period_s, color="black")
        force.set_title(words)
    figure.savefig(arguments.out)
    print(f"{arguments.out}: {len(tape)} ticks, {len(tape.cycles)} cycles, {len(tape.faults)} faults"
          + (f"; damaged: {tape.damage}" if tape.damage else ""))


if __name__ == "__main__":
    main()
