// Options and execution shared by `tactus experiment energy-loss` and `couplings`. Thread:
// [setup].
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
  double whole_s{0};  // length of whole runs; 0: none
  std::string order{"best-first"};
  PartOptions parts;
  OutputOptions output;
};

// Help text of both: what a whole run is, and when a body stands.
inline constexpr const char* kWholeRunsHelp =
    "--whole SECONDS also compares whole runs, from rest, with the scene's own hand. closed: the arm is in the\n"
    "loop of the run itself. direct: the arm's motion is that of the direct run (not with --quick). off: distance\n"
    "of the body that is farthest from its pose in the direct run, at the end and at any time. by quarter: force\n"
    "error of each quarter over the force of the whole run. A body stands if it ends within half of its smallest\n"
    "extent of its pose in the direct run, turned by less than 0.5 rad; a body that the direct run itself drops,\n"
    "turns over or leaves faster than 1 cm/s does not count. gain: kinetic and potential energy beyond the start\n"
    "and the hand's work, less that of the direct run, as a share of the energy at play (the hand's work and each\n"
    "body's weight times its extent). The row '1 um apart' is a direct run whose proxy starts 1 um aside: smaller\n"
    "deviations cannot be told from chance. The row '2x sub-steps' is a direct run with twice the sub-steps: its\n"
    "deviation is the uncertainty of the direct run. --seeds 0 omits the windows.\n";

void add_coupling_options(CLI::App& command, CouplingOptions& options);

// Runs the experiment, prints it and returns the exit status. `schemes`: each is run at every ratio.
int run_coupling_experiment(const CouplingOptions& options, const std::vector<experiment::Scheme>& schemes);

}  // namespace tactus::tools
