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
    "--whole SECONDS also compares whole runs, from rest, with the scene's own hand: closed, its arm in the loop of\n"
    "the run itself, and direct, the arm's motion of the direct run (not with --quick). off: the body farthest from\n"
    "where the direct run has it, at the end and at any time. by quarter: each over the force of the whole run. A\n"
    "body stands where it ends within half of its smallest extent of where the direct run has it, turned by less than\n"
    "0.5 rad against it; what the direct run itself drops, turns over or leaves faster than 1 cm/s does not count.\n"
    "gain: kinetic and potential energy beyond the start and the hand's work, less the direct run's, of the energy at\n"
    "play (the hand's work and each body's weight times its extent). The row '1 um apart' is a direct run whose proxy\n"
    "starts 1 um aside: less than it is off by cannot be told from chance. The row '2x sub-steps' is a direct run of\n"
    "as many: by that the direct run itself is not known better. --seeds 0 leaves the windows out.\n";

void add_coupling_options(CLI::App& command, CouplingOptions& options);

// Runs the experiment, prints it and returns the exit status. `schemes`: each is run at every ratio.
int run_coupling_experiment(const CouplingOptions& options, const std::vector<experiment::Scheme>& schemes);

}  // namespace tactus::tools
