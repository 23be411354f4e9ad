// tactus tune SCENE: finds the most accurate setting that this PC can run.
#include <fmt/format.h>

#include <memory>

#include "sim/loader/scene_load.h"
#include "tools/session/cores.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/help_texts.h"
#include "tools/tactus/in_range.h"
#include "tools/tactus/stop_signals.h"
#include "tools/timing/budget.h"
#include "tools/tune/tune.h"

namespace tactus::tools {
namespace {

struct TuneCommand {
  tune::TuneRequest request;
  std::string budget;
  bool json{false};
};

// Limits the search to the budget certified on this machine.
int keep_budget(TuneCommand& command) {
  if (command.budget.empty()) return kExitGood;
  const auto budget = timing::load_budget(command.budget);
  if (!budget.ok()) return complain("tactus tune: --budget: " + budget.message(), kExitBadInput);
  tune::TuneRequest& request = command.request;
  const int cpu = session::core_of_hand(request.run.cpu);
  const auto answer = timing::check_budget(budget.value(), timing::this_machine(cpu),
                                           {request.run.rate_Hz, 1, 1, request.run.priority});
  if (!answer.refusal.empty()) return complain("tactus tune: --budget: " + answer.refusal, kExitMachineCannot);
  request.limits.members = budget.value().members;
  request.limits.sub_steps = budget.value().sub_steps;
  request.run.late_s = 1e-6 * budget.value().wake_p99_9_us;
  return kExitGood;
}

int run_tune_command(TuneCommand& command) {
  auto scene = sim::load_scene(command.request.file);
  if (!scene.ok()) return complain_of_each(scene.message(), kExitBadInput);
  command.request.scene = std::move(scene).value();
  if (const int exit_code = keep_budget(command); exit_code != kExitGood) return exit_code;
  stop_on_signals();
  if (command.request.quick) command.request.verify_s = 2;
  const auto report = tune::run_tune(command.request, experiment::terminal_progress(), g_stop);
  if (!report.ok()) return complain("tactus tune: " + report.message(), kExitBadInput);
  fmt::print("{}\n", command.json ? tune::tune_json(report.value()) : tune::tune_text(report.value()));
  return report.value().good() ? kExitGood : kExitVerdictBad;
}

}  // namespace

CLI::App* add_tune_command(CLI::App& program, int& exit_code) {
  auto command = std::make_shared<TuneCommand>();
  tune::TuneRequest& request = command->request;
  CLI::App* app =
      program.add_subcommand("tune", "Find the most accurate setting of a scene that this PC can run in real time.");
  app->footer(
      "Sub-steps, relax sweeps, members and ratio are changed one step at a time from the scene's values, as long\n"
      "as the error of the force falls and the tick takes less than 0.6 ms, the governor's budget at 1 kHz.\n"
      "The error is measured in virtual time with the scene's own hand, against a run of all bodies at 1 kHz. The\n"
      "scene therefore has at most 256 moving bodies, and its hand touches something in the first 6 s (with --quick\n"
      "3 s). The chosen setting is then run in real time on the simulated device. The stiffness of contacts is not\n"
      "changed; the result says what a change would cost. Exit status: 0 good; 1 no setting suffices, the chosen\n"
      "one fails in real time, or the scene is bad; 2 bad usage or scene; 3 the budget is of another machine.\n\n"
      "Examples:\n"
      "  tactus tune sim/scenes/stack20.toml\n"
      "  tactus tune sim/scenes/pile250.toml --cpu 3 --budget budget.json --json");
  app->add_option("SCENE", request.file, "scene file, such as sim/scenes/stack20.toml")->required();
  app->add_option("--budget", command->budget,
                  std::string(help::kBudget) + "; its members and sub-steps are the largest that are tried");
  app->add_option("--cpu", request.run.cpu, help::kCpu)->check(in_range(session::kCores));
  app->add_option("--priority", request.run.priority, help::kPriority)
      ->check(in_range(session::kPriorities))
      ->capture_default_str();
  app->add_flag("--quick", request.quick, "measure less: two windows, real runs of 2 s, in half a minute");
  app->add_flag("--json", command->json, help::kJson);
  app->callback([command, &exit_code] { exit_code = run_tune_command(*command); });
  return app;
}

}  // namespace tactus::tools
