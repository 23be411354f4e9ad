// The options of `tactus run`. Thread: main.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tactus/tactus.h"
#include "tools/service/configuration.h"
#include "tools/tactus/run_hands.h"

namespace CLI {
class App;
}

namespace tactus::tools {

struct RunCommand {
  Options options;
  EachHand each;  // options given once for all hands, or once for each
  double duration_s{0};
  bool virtual_time{false};
  std::string world_cpus;
  std::filesystem::path scene, record, budget, config, control;
  service::Configuration configuration;
  std::string hand{"script"};
  double pace{-1};                   // below 0: not given
  std::vector<std::string> figures;  // COLUMN:HOW
  bool view{false}, json{false};
};

// Adds the options, in the order in which --help lists them; parsing fills `command`.
void add_run_options(CLI::App& app, RunCommand& command);

}  // namespace tactus::tools
