// tactus run of a scene with several hands: a device, a haptic thread, a control socket, a page, a summary and a tape
// for each.
// Thread: main.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sim/model/scene.h"
#include "tools/service/configuration.h"
#include "tools/session/run_options.h"

namespace tactus::tools {

inline constexpr double kDefaultVirtual_s = 10;  // of virtual time, without --duration, --view and --control

// Options that can be given once for all hands, or once for each hand.
struct EachHand {
  std::vector<std::string> devices, device_files;
  std::vector<std::string> injects;  // fewer than hands: of the first ones
  std::vector<int> cpus;             // the same
};

struct HandsCommand {
  const sim::Scene& scene;
  session::RunOptions options;  // of all hands
  EachHand each;
  std::filesystem::path record, control;  // of the first hand; of the others: session::file_of_hand. Empty: none
  std::filesystem::path config;           // empty: no service
  service::Configuration configuration;   // of the service
  std::vector<std::string> warnings;      // of the scene
  std::vector<std::string> figures;       // COLUMN:HOW, of each hand; virtual time without watchers
  double pace{0};                         // of virtual time with control sockets; 0: as fast as it goes
  bool view{false};                       // a viewer for each control socket
  bool by_pointer{false};                 // the simulated hands rest until a page's mouse takes them
  bool json{false};
};

// The options of each hand. Error, one line: as many of an option as the scene has hands, or one where it serves all: a
// real device serves one hand.
Result<std::vector<session::RunOptions>> options_of_hands(const HandsCommand& command);

// Returns the exit status: the worst of the hands'.
int run_hands(const HandsCommand& command);

}  // namespace tactus::tools
