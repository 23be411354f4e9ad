// tactus experiment stability-map: which gains of the device-proxy coupling are stable, and which to use on this PC.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <memory>

#include "tools/experiment/stability/stability_map.h"
#include "tools/session/cores.h"
#include "tools/session/find_description.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/experiment_output.h"
#include "tools/tactus/experiments.h"
#include "tools/tactus/help_texts.h"
#include "tools/tactus/in_range.h"
#include "tools/timing/budget.h"

namespace tactus::tools {
namespace {

struct MapOptions {
  std::string profile{"virtuose6d"}, device_file, budget;
  double rate_Hz{1000};
  int cpu{-1};
  OutputOptions output;
};

Result<experiment::WakeLateness> lateness_of(const MapOptions& options) {
  if (options.budget.empty())
    return experiment::measure_wake(options.rate_Hz, options.output.quick ? 2 : 10, options.cpu);
  const auto budget = timing::load_budget(options.budget);
  if (!budget.ok()) return budget.status();
  const timing::Budget& b = budget.value();
  return experiment::WakeLateness{.typical_s = 1e-6 * b.wake_p50_us,
                                  .late_s = 1e-6 * b.wake_p99_9_us,
                                  .latest_s = 1e-6 * b.wake_worst_us,
                                  .source = options.budget,
                                  .degraded = false};
}

// The command line that gives the same figures.
std::string command_of(const MapOptions& o) {
  std::string text = fmt::format("tactus experiment stability-map --rate {:g}", o.rate_Hz);
  text += o.device_file.empty() ? " --profile " + o.profile : " --device-file " + o.device_file;
  if (!o.budget.empty()) text += " --budget " + o.budget;
  return text + (o.output.quick ? " --quick" : "");
}

int run_map(const MapOptions& options) {
  const auto profile = session::find_description(options.profile, options.device_file);
  if (!profile.ok()) return experiment_failed("stability-map", profile.message());
  if (const Status status = session::check_core("--cpu", options.cpu); !status.ok())
    return complain("tactus experiment stability-map: " + status.message(), kExitMachineCannot);
  const auto wake = lateness_of(options);
  if (!wake.ok()) return experiment_failed("stability-map", "--budget: " + wake.message());
  experiment::MapRequest request;
  request.description = profile.value().description;
  request.rate_Hz = options.rate_Hz;
  request.wake = wake.value();
  request.quick = options.output.quick;
  const auto report = experiment::run_stability_map(request, experiment::terminal_progress());
  const ExperimentText text{.name = "stability-map",
                            .table = experiment::map_table(report),
                            .json = experiment::map_json(report),
                            .csv = experiment::map_csv(report)};
  return draw_page(options.output, text, command_of(options), print_and_write(options.output, text));
}

}  // namespace

void add_stability_map(CLI::App& experiment, int& exit_code) {
  auto options = std::make_shared<MapOptions>();
  CLI::App* command = experiment.add_subcommand(
      "stability-map", "Find which stiffness and damping of the coupling are stable, and which to use on this PC.");
  command->footer(
      "The simulated device is pressed against a wall with 5 N and tapped, without passivity controller and dry\n"
      "friction. For each damping the map has the stiffness at which the oscillation after the tap no longer\n"
      "decays, found by bisection, beside the formula by which `tactus run` refuses gains. Rate, delay, jitter and\n"
      "encoder quantum are changed one at a time. Virtual time: the same options give the same map. How late this\n"
      "PC wakes a thread is measured for some seconds, or read from a budget file; the suggested gains suit a tick\n"
      "that is as late as one in a thousand.\n\n"
      "Examples:\n"
      "  tactus experiment stability-map --quick\n"
      "  tactus experiment stability-map --budget budget.json --page stability.html");
  command->add_option("--profile", options->profile, help::kProfile)->capture_default_str();
  command->add_option("--device-file", options->device_file, std::string(help::kDeviceFile) + "; default: --profile");
  command->add_option("--rate", options->rate_Hz, std::string(help::kRate) + ", from which the rate is varied")
      ->check(in_range(session::kRates_Hz, "Hz"))
      ->capture_default_str();
  command->add_option("--cpu", options->cpu, "core on which wake-ups are measured; default: any")
      ->check(in_range(session::kCores));
  command->add_option("--budget", options->budget,
                      std::string(help::kBudget) + ", from which wake-up times are read instead of measured");
  options->output.add_csv(*command);
  options->output.add_page(*command);
  options->output.add_quick(*command, "four dampings, fewer loops, in less than a minute");
  options->output.add_json(*command);
  command->callback([options, &exit_code] { exit_code = run_map(*options); });
}

}  // namespace tactus::tools
