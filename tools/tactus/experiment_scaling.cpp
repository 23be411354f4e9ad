// tactus experiment scaling: how the cost of a step grows.
#include "tools/experiment/scaling.h"

#include <fmt/format.h>

#include <memory>
#include <string>

#include "rt/thread/realtime_setup.h"
#include "sim/model/choice_names.h"
#include "tools/experiment/timing.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/experiment_output.h"
#include "tools/tactus/experiments.h"
#include "tools/tactus/help_texts.h"

namespace tactus::tools {
namespace {

struct ScalingOptions {
  std::string precision;
  int count{-1};
  OutputOptions output;
};

int run_scaling(const ScalingOptions& options) {
  experiment::EngineOptions engine;
  engine.precision = sim::parse_precision(options.precision);
  const auto cases = experiment::scaling_cases(options.output.quick, loop::allowed_cpus().size());
  if (options.count >= 0) {
    const auto index = static_cast<std::size_t>(options.count);
    if (index >= cases.size()) return experiment_failed("scaling", "--count: no such case");
    experiment::run_counted(cases[index], engine);
    return kExitGood;
  }
  const auto report =
      experiment::run_scaling(cases, engine, own_program(), options.output.quick, experiment::terminal_progress());
  int exit_code = print_and_write(options.output, {.name = "scaling",
                                                   .table = experiment::scaling_table(report),
                                                   .json = experiment::scaling_json(report),
                                                   .csv = experiment::scaling_csv(report),
                                                   .svg = experiment::scaling_svg(report)});
  for (const auto& row : report.rows)
    if (!row.failure.empty())
      exit_code =
          complain(fmt::format("tactus experiment scaling: {} cubes: {}", row.bodies, row.failure), kExitVerdictBad);
  return exit_code;
}

}  // namespace

void add_scaling(CLI::App& experiment, int& exit_code) {
  auto options = std::make_shared<ScalingOptions>();
  CLI::App* scaling = experiment.add_subcommand(
      "scaling", "Measure how the cost of a step grows with bodies, contacts, sub-steps, sizes and threads.");
  scaling->footer(
      "One core, CPU time; the series over threads has a core for each thread and measures wall time. Where\n"
      "valgrind is installed, the instructions of worlds of up to 1000 cubes are counted too. Exit status 1: a\n"
      "capacity cut the work of a row, which then does not count.\n\n"
      "Example:\n"
      "  tactus experiment scaling --csv scaling.csv --svg scaling.svg");
  scaling->add_option("--precision", options->precision, std::string("precision of tactus: ") + help::kPrecision)
      ->check(CLI::IsMember({"double", "mixed"}));
  options->output.add_csv(*scaling);
  options->output.add_svg(*scaling, "cost against contact points");
  scaling->add_option("--count", options->count, "case to run, for the count of instructions")->group("");
  options->output.add_quick(*scaling, "worlds of up to 1000 cubes, fewer steps");
  options->output.add_json(*scaling);
  scaling->callback([options, &exit_code] { exit_code = run_scaling(*options); });
}

}  // namespace tactus::tools
