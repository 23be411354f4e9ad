// tactus tune SCENE: finds the most accurate setting that this PC can run.
#include <fmt/format.h>

#include <memory>

#include "sim/loader/scene_load.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/stop_signals.h"
#include "tools/timing/budget.h"
#include "tools/timing/load.h"
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
  const int cpu = request.run.cpu >= 0 ? request.run.cpu : timing::cores_without(-1).back();
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
  CLI::App* app = program.add_subcommand("tune", "The most accurate setting of a scene that this PC bears.");
  app->footer(
      "Sub-steps, relax sweeps, members and ratio are changed a notch at a time, from what the scene says, as long as\n"
      "the error of the force falls and the tick stays below 0.6 of its millisecond, the governor's budget. The error\n"
      "is measured in virtual time on the scene's own hand, against all bodies at 1 kHz; so the scene has at most 256\n"
      "that move, and its hand touches something in its first 6 s (with --quick 3 s). Then the choice is run in real\n"
      "time on the simulated device. Contacts are never made stiffer or softer: what that would cost is said.\n"
      "Exit status: 0 good; 1 nothing fits, the choice does not hold, or the scene is bad; 2 bad usage or scene; 3 the "
      "budget is not\n"
      "this machine's.\n\n"
      "Examples:\n  tactus tune sim/scenes/stack20.toml\n  tactus tune sim/scenes/pile250.toml --cpu 3 --budget "
      "budget.json --json");
  app->add_option("SCENE", request.file, "the scene, such as sim/scenes/stack20.toml")->required();
  app->add_option("--budget", command->budget,
                  "a file of `tactus timing --certify`: no more members and sub-steps than were measured");
  app->add_option("--cpu", request.run.cpu, "core of the haptic thread; default: the last one allowed")
      ->check(CLI::Range(0, 1023));
  app->add_option("--priority", request.run.priority,
                  "SCHED_FIFO priority of the haptic thread; 0: stay a normal thread")
      ->capture_default_str();
  app->add_flag("--quick", request.quick, "half a minute: two windows, real runs of two seconds");
  app->add_flag("--json", command->json, "one JSON object on stdout, units in the keys");
  app->callback([command, &exit_code] { exit_code = run_tune_command(*command); });
  return app;
}

}  // namespace tactus::tools
