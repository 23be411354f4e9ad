// tactus experiment capacity: how many bodies each coupling sustains (paper, section 3.1).
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <memory>

#include "sim/model/choice_names.h"
#include "tools/experiment/coupling/capacity.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/experiment_output.h"
#include "tools/tactus/experiments.h"
#include "tools/tactus/help_texts.h"
#include "tools/tactus/in_range.h"

namespace tactus::tools {
namespace {

struct CapacityOptions {
  std::vector<double> rates_Hz;
  std::vector<unsigned> ratios;
  std::vector<std::string> couplings{"direct", "sub-world", "static", "interpolation"};
  unsigned members{64}, most{20000};
  OutputOptions output;
};

int run_capacity(const CapacityOptions& options) {
  experiment::CapacityRequest request;
  request.rates_Hz = options.rates_Hz;
  if (request.rates_Hz.empty())
    request.rates_Hz = options.output.quick ? std::vector<double>{1000} : std::vector<double>{1000, 2000, 4000};
  request.ratios = options.ratios;
  if (request.ratios.empty())
    request.ratios = options.output.quick ? std::vector<unsigned>{10} : std::vector<unsigned>{2, 4, 10, 16};
  for (const std::string& word : options.couplings)
    request.couplings.push_back({.coupling = *sim::parse_coupling_scheme(word)});
  request.members = options.members;
  request.most_bodies = options.most;
  if (options.output.quick) {
    request.ticks = 200;
    request.runs = 3;
  }
  const auto report = experiment::run_capacity(request, experiment::terminal_progress());
  if (!report.ok()) return experiment_failed("capacity", report.message());
  const ExperimentText text{.name = "capacity",
                            .table = experiment::capacity_table(report.value()),
                            .json = experiment::capacity_json(report.value()),
                            .csv = experiment::capacity_csv(report.value())};
  const std::string command =
      fmt::format("tactus experiment capacity --rates {} --ratios {} --couplings {} --members {} --most {}{}",
                  fmt::join(request.rates_Hz, ","), fmt::join(request.ratios, ","), fmt::join(options.couplings, ","),
                  options.members, options.most, options.output.quick ? " --quick" : "");
  return draw_page(options.output, text, command, print_and_write(options.output, text));
}

}  // namespace

void add_capacity(CLI::App& experiment, int& exit_code) {
  auto options = std::make_shared<CapacityOptions>();
  CLI::App* command =
      experiment.add_subcommand("capacity", "Measure how many bodies each coupling sustains, by rate and ratio.");
  command->footer(
      "The proxy stirs a heap of cubes of up to eight layers, all awake. A heap is sustained if 99 of 100 ticks\n"
      "compute for less than the tick and 9 of 10 global steps for less than their r ticks (CPU times; the\n"
      "global world is computed on a core of its own, if there are two, while the ticks go on). A heap that is too\n"
      "slow is run again, up to five times in all (three with --quick); the least time of each tick and step counts.\n"
      "The number of cubes is doubled until a heap is too slow, then bisected to a factor of 2^(1/8). As in pile5000,\n"
      "contacts are of 100 Hz, a tick is one sub-step at every rate, and the global world has one for every two "
      "ticks.\n\n"
      "Examples:\n"
      "  tactus experiment capacity --quick\n"
      "  tactus experiment capacity --rates 1000 --ratios 10 --page capacity.html");
  command
      ->add_option("--rates", options->rates_Hz,
                   "rates of the haptic loop [Hz], separated by commas; default: 1000,2000,4000")
      ->delimiter(',')
      ->check(in_range(session::kRates_Hz, "Hz"));
  command->add_option("--ratios", options->ratios, help::list_of(help::kRatio, "2,4,10,16"))
      ->delimiter(',')
      ->check(in_range(session::kRatios));
  command
      ->add_option("--couplings", options->couplings,
                   "coupling schemes, separated by commas; 'times direct' is computed only if direct is the first")
      ->delimiter(',')
      ->check(CLI::IsMember({"direct", "sub-world", "static", "interpolation"}))
      ->capture_default_str();
  command->add_option("--members", options->members, help::kMembers)
      ->check(in_range(session::kMemberCaps))
      ->capture_default_str();
  command->add_option("--most", options->most, "largest number of cubes to try in a heap")
      ->check(in_range(25, 90000))
      ->capture_default_str();
  options->output.add_csv(*command);
  options->output.add_page(*command);
  options->output.add_quick(*command, "1 kHz and ratio 10, in about a minute");
  options->output.add_json(*command);
  command->callback([options, &exit_code] { exit_code = run_capacity(*options); });
}

}  // namespace tactus::tools
