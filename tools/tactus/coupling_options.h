// Options and execution shared by `tactus experiment energy-loss` and `couplings`. Thread: [setup].
#pragma once

#include <string>
#include <vector>

#include "tools/experiment/coupling/coupling_study.h"
#include "tools/tactus/experiment_output.h"
#include "tools/tactus/experiment_parts.h"

namespace CLI {
class App;
}

namespace tactus::tools {

struct CouplingOptions {
  std::string name;  // of the experiment
  std::vector<std::string> scenes, scene_files, borders;
  std::vector<unsigned> ratios, members;
  unsigned seeds{20};
  double whole_s{0};               // length of whole runs; 0: none
  std::vector<std::string> hands;  // of whole runs; empty: closed and direct, closed alone if quick
  std::string order{"best-first"};
  PartOptions parts;
  OutputOptions output;
};

// Help text of both: the terms of a whole run. The rule of `stands` is experiment::StandingRule.
inline constexpr const char* kWholeRunsHelp =
    "--whole SECONDS also compares whole runs, from rest, with the scene's own hand; --seeds 0 omits the windows:\n"
    "With --hands none the direct run has no device either: gain is then what the coupling creates. Terms:\n"
    "  by quarter    force error of each quarter of the run, relative to the force of the whole run\n"
    "  off, most     distance of the farthest body from its place in the direct run: at the end, at any time\n"
    "  gain          kinetic and potential energy beyond the start and the hand's work, less that of the direct\n"
    "                run, as a share of the energy at play: the hand's work and each body's weight times its extent.\n"
    "                Motors, kinematic bodies, attraction and restitution also do work: with them gain is the\n"
    "                difference of that work between the two runs too, and no measure of energy from nothing\n"
    "  spent         ticks in which the border's energy tank is empty: from there on it only takes. --json and --csv\n"
    "                list the energy of the device, the border, the corrections and the global world\n"
    "  stands        no body falls, and the force is finite and never above 10 kN (else the run is lost and ends).\n"
    "                A body falls if it ends more than half of its smallest extent from its place in the direct\n"
    "                run or, unless it is a ball, turned by 0.5 rad or more. Not counted are bodies that end the\n"
    "                direct run faster than 1 cm/s, and those that fall in it: they sink by more than half of\n"
    "                their smallest extent or, unless they are balls, turn by 0.5 rad or more\n"
    "  1 um apart    row of a direct run whose proxy starts 1 um aside: smaller deviations are chance\n"
    "  2x sub-steps  row of a direct run with twice the sub-steps: its deviation is the direct run's uncertainty\n";

void add_coupling_options(CLI::App& command, CouplingOptions& options);

// Runs the experiment, prints it and returns the exit status. `schemes`: each is run at every ratio.
int run_coupling_experiment(const CouplingOptions& options, const std::vector<experiment::Scheme>& schemes);

}  // namespace tactus::tools
