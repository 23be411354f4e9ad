// tactus experiment scaling: how the cost of a step grows.
#include "tools/experiment/scaling.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include "sim/model/choice_names.h"
#include "tools/experiment/timing.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/experiments.h"

namespace tactus::tools {
namespace {

struct ScalingOptions {
  std::string precision, csv, svg;
  int count{-1};
  bool quick{false}, json{false};
};

int run_scaling(const ScalingOptions& options) {
  experiment::EngineOptions engine;
  engine.precision = sim::parse_precision(options.precision);
  const auto cases = experiment::scaling_cases(options.quick, experiment::allowed_cores().size());
  if (options.count >= 0) {
    const auto index = static_cast<std::size_t>(options.count);
    if (index >= cases.size()) return complain("tactus experiment scaling: --count: no such case", kExitBadInput);
    experiment::run_counted(cases[index], engine);
    return kExitGood;
  }
  std::error_code ignored;
  const std::string program = std::filesystem::read_symlink("/proc/self/exe", ignored).string();
  const auto report = experiment::run_scaling(cases, engine, program, options.quick, experiment::terminal_progress());
  fmt::print("{}\n", options.json ? experiment::scaling_json(report) : experiment::scaling_table(report));
  int exit_code = std::max(write_file(options.csv, experiment::scaling_csv(report)),
                           write_file(options.svg, experiment::scaling_svg(report)));
  for (const auto& row : report.rows)
    if (!row.failure.empty())
      exit_code =
          complain(fmt::format("tactus experiment scaling: {} cubes: {}", row.bodies, row.failure), kExitVerdictBad);
  return exit_code;
}

}  // namespace

void add_scaling(CLI::App& experiment, int& exit_code) {
  auto options = std::make_shared<ScalingOptions>();
  CLI::App* scaling =
      experiment.add_subcommand("scaling", "How a step's cost grows with bodies, contacts, sub-steps, sizes, threads.");
  scaling->footer(
      "One core, CPU time; the sweep of threads has a core for each and goes by the wall clock. Where valgrind is\n"
      "installed, instructions are counted too, of the worlds of up to 1000 cubes. Exit status 1: work was left out "
      "by\n"
      "a capacity, and the row does not count.\n\n"
      "Example:\n  tactus experiment scaling --csv scaling.csv --svg scaling.svg");
  scaling
      ->add_option(
          "--precision", options->precision,
          "double, or mixed, where contacts are solved in single precision;\ndefault: as in a run, mixed beyond "
          "256 bodies")
      ->check(CLI::IsMember({"double", "mixed"}));
  scaling->add_option("--csv", options->csv, "writes the rows to this file");
  scaling->add_option("--svg", options->svg, "plots cost against contact points into this file");
  scaling->add_option("--count", options->count, "runs one case for the count of instructions")->group("");
  scaling->add_flag("--quick", options->quick, "worlds of up to 1000 cubes, shorter");
  scaling->add_flag("--json", options->json, "one JSON object on stdout");
  scaling->callback([options, &exit_code] { exit_code = run_scaling(*options); });
}

}  // namespace tactus::tools
