// tactus config check FILE: checks a deployment's configuration, and the scene, the device and the budget that it
// names.
#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "hal/device_file.h"
#include "rt/text/without_control.h"
#include "sim/loader/scene_load.h"
#include "tools/doctor/system_view.h"
#include "tools/json_report.h"
#include "tools/service/configuration.h"
#include "tools/session/distinct_devices.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/help_texts.h"
#include "tools/timing/budget.h"

namespace tactus::tools {
namespace {

struct ConfigOptions {
  std::string file;
  bool json{false};
};

// The existing cores; empty if the kernel does not report them.
std::optional<std::vector<int>> cores_of_machine() {
  const auto system = doctor::SystemView::open("/");
  if (!system.ok()) return std::nullopt;
  const auto cores = doctor::parse_cpu_list(system.value().read("/sys/devices/system/cpu/online").value_or(""));
  return cores && !cores->empty() ? cores : std::nullopt;
}

std::string names_of(const std::vector<service::ConfiguredDevice>& devices) {
  std::string names;
  for (const service::ConfiguredDevice& device : devices) names += (names.empty() ? "" : ", ") + device.name;
  return names;
}

// All mistakes in the file and in the files that it names, one per line.
std::vector<std::string> problems_of(const ConfigOptions& options, std::string& good) {
  std::vector<std::string> problems;
  const auto add = [&](const std::string& lines) {
    std::istringstream stream(lines);
    for (std::string line; std::getline(stream, line);) problems.push_back(line);
  };
  const auto reading = service::read_configuration(std::filesystem::path(options.file), cores_of_machine());
  add(reading.mistakes);
  const session::RunOptions& run = reading.configuration.run;
  if (!run.scene.empty()) {
    const auto scene = sim::load_scene(run.scene);
    add(scene.message());
    if (scene.ok())
      good = fmt::format("{}: good; {} on {} at {:g} Hz", options.file,
                         scene.value().title.empty() ? scene.value().name : scene.value().title,
                         reading.configuration.devices.empty() ? run.device : names_of(reading.configuration.devices),
                         run.rate_Hz);
    const std::size_t devices = std::max<std::size_t>(1, reading.configuration.devices.size());
    if (scene.ok() && devices != 1 && devices != scene.value().hands())
      add(fmt::format("{}: [[device]]: {} for {} hands of the scene; accepted: one for all, or one for each",
                      options.file, devices, scene.value().hands()));
  }
  if (!run.device_file.empty()) add(hal::load_device_file(run.device_file).message());
  for (std::size_t i = 1; i < reading.configuration.devices.size(); ++i)
    if (const auto& file = reading.configuration.devices[i].file; !file.empty())
      add(hal::load_device_file(file).message());
  std::vector<session::NamedDevice> named;
  for (const service::ConfiguredDevice& device : reading.configuration.devices)
    named.push_back({device.name, device.file});
  if (const Status status = session::check_distinct(named, "virtuose6d"); !status.ok())
    add(fmt::format("{}: [[device]]: {}", options.file, status.message()));
  if (const auto& budget = reading.configuration.budget; !budget.empty())
    add(timing::load_budget(budget.string()).message());
  return problems;
}

int check_file(const ConfigOptions& options) {
  std::string good;
  const std::vector<std::string> problems = problems_of(options, good);
  if (options.json)
    fmt::print("{}\n", report_text(nlohmann::ordered_json{{"good", problems.empty()}, {"problems", problems}}, 2));
  else if (problems.empty())
    fmt::print("{}\n", good);
  for (const std::string& problem : problems) fmt::print(stderr, "{}\n", text::without_control(problem, '\n'));
  return problems.empty() ? kExitGood : kExitBadInput;
}

}  // namespace

CLI::App* add_config_command(CLI::App& program, int& exit_code) {
  auto options = std::make_shared<ConfigOptions>();
  CLI::App* config = program.add_subcommand("config", "Check the configuration file of an installed tactus.");
  config->footer("Example:\n  tactus config check /etc/tactus/tactus.toml");
  CLI::App* check = config->add_subcommand(
      "check", "Report every mistake in the file, and in the scene, device and budget that it names.");
  check->footer(
      "Tables: scene = PATH; [device] name, file, gpio; [[device]] name, file, gpio, core;\n"
      "[rates] rate_Hz, ratio; [cores] haptic, priority, world, world_threads;\n"
      "[limits] members, budget; [control] socket, arm_at_start, rearm; [log] interval_s.\n"
      "Exit status: 0 good; 2 mistakes, a line for each.\n\nExample:\n  tactus config check "
      "/etc/tactus/tactus.toml");
  check->add_option("FILE", options->file, "configuration file (TOML)")->required();
  check->add_flag("--json", options->json, help::kJson);
  check->callback([options, &exit_code] { exit_code = check_file(*options); });
  return config;
}

}  // namespace tactus::tools
