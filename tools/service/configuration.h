// What an installed tactus runs: one TOML file for the device, the scene, the rates, the cores and the limits.
//
// Same quality of messages as for scenes: file, line, column, key, what was found, what is accepted; a mistake never
// hides the next one. Every key may be left out but `scene`; relative paths are from the file's folder. What may change
// while it runs (`reload`): [control] rearm and [log] interval_s. Units: in the keys. Thread: [setup].
// Bound: kMaxConfigurationBytes; a longer file is refused by a mistake like any other.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/session/run_options.h"

namespace tactus::service {

inline constexpr std::size_t kMaxConfigurationBytes = 64u << 10;

struct Configuration {
  session::RunOptions run;       // [device] [rates] [cores] [limits]
  std::filesystem::path budget;  // of `tactus timing --certify`; empty: none
  std::filesystem::path socket;  // of `tactus control`; empty: none
  double log_interval_s{1};      // the same event at most once in this time
};

// What is wrong with the file, a line each, and what it says all the same, by default where it is wrong.
struct ConfigurationReading {
  Configuration configuration;
  std::string mistakes;
};
// `cores`: those that the machine has; a core that is not among them is a mistake. Nothing: any is good.
ConfigurationReading read_configuration(const std::filesystem::path& path,
                                        const std::optional<std::vector<int>>& cores);
ConfigurationReading read_configuration(std::string_view text, std::string_view name,
                                        const std::optional<std::vector<int>>& cores);

// Checks ranges and combinations too, as for options of `tactus run`. The message lists every mistake, a line each.
Result<Configuration> parse_configuration(std::string_view text, std::string_view name);
Result<Configuration> load_configuration(const std::filesystem::path& path);

// The keys that differ and need a restart, in one line; empty: all that differs is safe to change.
std::string needs_restart(const Configuration& before, const Configuration& after);

}  // namespace tactus::service
