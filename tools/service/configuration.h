// Configuration of the installed service: one TOML file for the device, the scene, the rates, the cores and the limits.
//
// Messages as for scenes: file, line, column, key, what was found, what is accepted. Reading continues after a mistake.
// Only `scene` is required; relative paths are from the file's folder. `reload` may change during a run: [control]
// rearm and [log] interval_s. Units: in the keys. Thread: [setup].
// Bound: kMaxConfigurationBytes; a longer file is reported as a mistake.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/session/run_options.h"

namespace tactus::service {

inline constexpr std::size_t kMaxConfigurationBytes = 64u << 10;

// Of several hands, in the order of the scene's: [[device]].
struct ConfiguredDevice {
  std::string name{"sim"};
  std::filesystem::path file;
  int core{-1};  // of its haptic thread; -1: not given
  friend bool operator==(const ConfiguredDevice&, const ConfiguredDevice&) = default;
};

struct Configuration {
  session::RunOptions run;  // [device] [rates] [cores] [limits]; of several hands what they have in common
  std::vector<ConfiguredDevice> devices;  // two or more; empty: one device, in `run`
  std::filesystem::path budget;           // of `tactus timing --certify`; empty: none
  std::filesystem::path socket;           // of `tactus control`; empty: none
  double log_interval_s{1};               // minimum time between equal events
};

// The mistakes in the file, one per line, and its content, with defaults for wrong values.
struct ConfigurationReading {
  Configuration configuration;
  std::string mistakes;
};
// `cores`: cores of the machine; any other core is a mistake. Empty: every core is accepted.
ConfigurationReading read_configuration(const std::filesystem::path& path,
                                        const std::optional<std::vector<int>>& cores);
ConfigurationReading read_configuration(std::string_view text, std::string_view name,
                                        const std::optional<std::vector<int>>& cores);

// Also checks ranges and combinations, as for options of `tactus run`. The message lists every mistake, one per line.
Result<Configuration> parse_configuration(std::string_view text, std::string_view name);
Result<Configuration> load_configuration(const std::filesystem::path& path);

// The keys that differ and need a restart, in one line; empty: all differences may be applied during a run.
std::string needs_restart(const Configuration& before, const Configuration& after);

}  // namespace tactus::service
