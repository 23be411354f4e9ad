// tactus config check FILE: is this deployment's configuration good? And the scene, the device and the budget that it
// names.
#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "sim/loader/scene_load.h"
#include "tools/service/configuration.h"
#include "tools/session/device_file.h"
#include "tools/tactus/commands.h"
#include "tools/timing/budget.h"

namespace tactus::tools {
namespace {

struct ConfigOptions {
  std::string file;
  bool json{false};
};

int report(const ConfigOptions& options, const std::string& problems, const std::string& good) {
  if (options.json)
    fmt::print("{}\n", nlohmann::ordered_json{{"good", problems.empty()}, {"problems", problems}}.dump(2));
  if (problems.empty()) {
    if (!options.json) fmt::print("{}\n", good);
    return kExitGood;
  }
  fmt::print(stderr, "{}\n", problems);  // a line for each mistake
  return kExitBadInput;
}

int check_file(const ConfigOptions& options) {
  const auto configuration = service::load_configuration(options.file);
  if (!configuration.ok()) return report(options, configuration.message(), "");
  const session::RunOptions& run = configuration.value().run;
  const auto scene = sim::load_scene(run.scene);
  if (!scene.ok()) return report(options, scene.message(), "");
  if (!run.device_file.empty())
    if (const auto device = session::load_device_file(run.device_file); !device.ok())
      return report(options, device.message(), "");
  if (const auto& file = configuration.value().budget; !file.empty())
    if (const auto budget = timing::load_budget(file.string()); !budget.ok())
      return report(options, budget.message(), "");
  return report(
      options, "",
      fmt::format("{}: good; {} on {} at {:g} Hz", options.file,
                  scene.value().title.empty() ? scene.value().name : scene.value().title, run.device, run.rate_Hz));
}

}  // namespace

CLI::App* add_config_command(CLI::App& program, int& exit_code) {
  auto options = std::make_shared<ConfigOptions>();
  CLI::App* config = program.add_subcommand("config", "The configuration file of an installed tactus.");
  config->footer("Example:\n  tactus config check /etc/tactus/tactus.toml");
  CLI::App* check = config->add_subcommand(
      "check", "Says everything that is wrong with the file, and with the scene, device and budget that it names.");
  check->footer(
      "Tables: scene = PATH; [device] name, file, gpio; [rates] rate_Hz, ratio; [cores] haptic, priority, world,\n"
      "world_threads; [limits] members, budget; [control] socket, arm_at_start, rearm; [log] interval_s.\n"
      "Exit status: 0 good; 2 not, a line for each mistake.\n\nExample:\n  tactus config check "
      "/etc/tactus/tactus.toml");
  check->add_option("FILE", options->file, "TOML")->required();
  check->add_flag("--json", options->json, "one JSON object on stdout");
  check->callback([options, &exit_code] { exit_code = check_file(*options); });
  return config;
}

}  // namespace tactus::tools
