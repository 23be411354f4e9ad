// tactus experiment effects: cost of effects when used and when not used.
#include "tools/experiment/effects.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <string>

#include "tools/tactus/commands.h"
#include "tools/tactus/experiment_output.h"
#include "tools/tactus/experiments.h"

namespace tactus::tools {
namespace {

struct EffectsOptions {
  std::vector<std::string> effects;
  std::string count;
  OutputOptions output;
};

int run_effects(const EffectsOptions& options) {
  const auto known = experiment::effect_names();
  const auto is_known = [&](const std::string& name) {
    return std::find(known.begin(), known.end(), name) != known.end();
  };
  if (!options.count.empty()) {
    const auto colon = options.count.find(':');
    const std::string effect = options.count.substr(0, colon);
    const char state = colon == std::string::npos ? '?' : options.count.back();
    if (!is_known(effect) || state < '0' || state > '2') return experiment_failed("effects", "--count: no such case");
    experiment::count_effect(effect, static_cast<experiment::EffectState>(state - '0'));
    return kExitGood;
  }
  const auto rows = experiment::run_effects(options.effects.empty() ? known : options.effects, own_program(),
                                            experiment::terminal_progress());
  int exit_code = print_and_write(
      options.output,
      {.name = "effects", .table = experiment::effects_table(rows), .json = experiment::effects_json(rows)});
  for (const auto& row : rows) {
    if (row.instructions[0] == 0)
      return complain(
          "tactus experiment effects: nothing was counted: valgrind is not installed, or was not at the build",
          kExitMachineCannot);
    if (!row.good())
      exit_code = complain(fmt::format("tactus experiment effects: {}: declared and not used, it costs", row.effect),
                           kExitVerdictBad);
  }
  return exit_code;
}

}  // namespace

void add_effects(CLI::App& experiment, int& exit_code) {
  auto options = std::make_shared<EffectsOptions>();
  CLI::App* effects = experiment.add_subcommand(
      "effects", "Count the instructions that each effect costs: not declared, not used, used.");
  effects->footer(
      "Instructions of a tick, counted by callgrind, which needs valgrind. Exit status 1: an effect that is\n"
      "declared and not used costs more than 0.1 %.\n\n"
      "Example:\n"
      "  tactus experiment effects --effects joints,restitution");
  effects->add_option("--effects", options->effects, "effects to measure, separated by commas; default: all")
      ->delimiter(',')
      ->check(CLI::IsMember(experiment::effect_names()));
  effects->add_option("--count", options->count, "case to run, for the count of instructions")->group("");
  options->output.add_json(*effects);
  effects->callback([options, &exit_code] { exit_code = run_effects(*options); });
}

}  // namespace tactus::tools
