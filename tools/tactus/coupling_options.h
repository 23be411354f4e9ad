// What `tactus experiment energy-loss` and `couplings` have in common: their options, and how they end. Thread:
// [setup].
#pragma once

#include <string>
#include <vector>

#include "tools/experiment/coupling/coupling_study.h"

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
  std::string order{"best-first"}, csv, page;
  bool quick{false}, json{false};
};

void add_coupling_options(CLI::App& command, CouplingOptions& options);

// Runs it and prints; the exit status. `schemes`: each is run at every ratio.
int run_coupling_experiment(const CouplingOptions& options, const std::vector<experiment::Scheme>& schemes);

}  // namespace tactus::tools
