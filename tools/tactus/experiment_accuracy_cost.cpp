// tactus experiment accuracy-cost: computing time against accuracy.
#include <fmt/format.h>
#include <CLI/CLI.hpp>

#include <algorithm>
#include <memory>

#include "tools/experiment/coupling/accuracy_cost.h"
#include "tools/experiment/coupling/study_fields.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/experiment_output.h"
#include "tools/tactus/experiment_parts.h"
#include "tools/tactus/experiments.h"
#include "tools/tactus/help_texts.h"
#include "tools/tactus/in_range.h"

namespace tactus::tools {
namespace {

struct CostOptions {
  std::vector<std::string> scenes;
  unsigned seeds{0};            // 0: three, with --quick one
  std::vector<unsigned> count;  // hidden: scene and setting whose instructions are counted
  PartOptions parts;
  OutputOptions output;
};

// A part is one scene with one hand, of the hands from the second on: the first is measured here, where ticks are
// timed.
Result<std::vector<experiment::HandSums>> hands_elsewhere(const CostOptions& options,
                                                          const experiment::CostRequest& request,
                                                          const std::vector<std::string>& arguments) {
  const std::size_t parts = request.cases.size() * (request.seeds - 1);
  if (!options.parts.elsewhere() || parts == 0) return std::vector<experiment::HandSums>{};
  return parts_of<experiment::HandSums>(
      options.parts, {.arguments = arguments, .count = parts, .scenes = experiment::files_of(request.cases)});
}

Result<experiment::HandSums> run_part(const experiment::CostRequest& request, std::size_t part) {
  const unsigned hands = request.seeds - 1;
  auto sums = experiment::measure_hand(request.cases[part / hands], static_cast<unsigned>(1 + part % hands),
                                       request.quick, experiment::terminal_progress());
  if (sums.ok())
    for (auto& setting : sums.value()) {
      setting.ticks_us.clear();
      setting.global_us.clear();
    }
  return sums;
}

int run_cost(const CostOptions& options) {
  const auto cases = experiment::coupling_cases();
  if (options.count.size() == 2) {
    if (options.count[0] >= cases.size()) return experiment_failed("accuracy-cost", "no such case");
    const Status status = experiment::run_counted(cases[options.count[0]], options.count[1], options.output.quick);
    return status.ok() ? kExitGood : complain(status.message(), kExitBadInput);
  }
  experiment::CostRequest request;
  for (const auto& one : cases)
    if (options.scenes.empty() ||
        std::find(options.scenes.begin(), options.scenes.end(), one.name) != options.scenes.end())
      request.cases.push_back(one);
  const unsigned usual_seeds = options.output.quick ? 1 : 3;
  request.seeds = options.seeds > 0 ? options.seeds : usual_seeds;
  request.quick = options.output.quick;
  if (!options.output.quick) request.program = own_program();
  std::vector<std::string> arguments{"experiment", "accuracy-cost", "--seeds", fmt::format("{}", request.seeds)};
  if (!options.scenes.empty())
    arguments.insert(arguments.end(), {"--scenes", fmt::format("{}", fmt::join(options.scenes, ","))});
  if (options.output.quick) arguments.push_back("--quick");
  if (options.parts.part >= 0)
    return print_part(options.parts, "accuracy-cost", request.cases.size() * (request.seeds - 1),
                      [&](std::size_t part) { return run_part(request, part); });
  const auto elsewhere = hands_elsewhere(options, request, arguments);
  if (!elsewhere.ok()) return experiment_failed("accuracy-cost", elsewhere.message());
  const auto report = experiment::run_accuracy_cost(request, elsewhere.value(), experiment::terminal_progress());
  if (!report.ok()) return experiment_failed("accuracy-cost", report.message());
  const ExperimentText text{.name = "accuracy-cost",
                            .table = experiment::cost_table(report.value()),
                            .json = experiment::cost_json(report.value()),
                            .csv = experiment::cost_csv(report.value())};
  const std::string command = fmt::format("tactus {}", fmt::join(arguments, " "));
  return draw_page(options.output, text, command, print_and_write(options.output, text));
}

}  // namespace

void add_accuracy_cost(CLI::App& experiment, int& exit_code) {
  auto options = std::make_shared<CostOptions>();
  CLI::App* command = experiment.add_subcommand(
      "accuracy-cost", "Measure the error of the force against the time of a tick, by setting.");
  command->footer(
      "The experiment varies sub-steps, relax sweeps, friction, contact frequency, members, ratio, border,\n"
      "extraction and the precision of the global world. The reference is a run of all bodies at 1 kHz with 16\n"
      "sub-steps and two relax sweeps, on the windows of `energy-loss`; the error is thus that of the solver and\n"
      "of the coupling. A setting is on the front if no other is as accurate and cheaper in the median. Errors\n"
      "are of virtual time, the same on every machine; times are CPU time on this machine. Where valgrind is\n"
      "installed, the instructions of the front and of the default are counted too, not with --quick. All of it\n"
      "takes some twenty minutes. With --workers or --scheduler only the first hand is timed, by this process,\n"
      "after the others have ended.\n\n"
      "Examples:\n"
      "  tactus experiment accuracy-cost --quick\n"
      "  tactus experiment accuracy-cost --scenes pile,wall --page cost.html");
  command->add_option("--scenes", options->scenes, help::kScenes)
      ->delimiter(',')
      ->check(CLI::IsMember(experiment::coupling_case_names()));
  command->add_option("--seeds", options->seeds, help::kSeeds)
      ->check(in_range(1, 1000))
      ->default_str("3, with --quick 1");
  options->parts.add(*command);
  options->output.add_csv(*command);
  options->output.add_page(*command);
  command->add_option("--count", options->count, "case and setting, for the count of instructions")
      ->expected(2)
      ->group("");
  options->output.add_quick(*command, "one seed, two windows, one factor at a time, in a minute or two");
  options->output.add_json(*command);
  command->callback([options, &exit_code] { exit_code = run_cost(*options); });
}

}  // namespace tactus::tools
