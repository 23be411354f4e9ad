#include "tools/tactus/run_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "sim/model/choice_names.h"
#include "tools/tactus/help_texts.h"
#include "tools/tactus/in_range.h"
#include "tools/tactus/output_option.h"

namespace tactus::tools {
namespace {

// One value per option: the next word may be the scene.
void once_or_each(CLI::Option* option) { option->allow_extra_args(false); }

void add_view_options(CLI::App& app, RunCommand& command) {
  app.add_option("--control", command.control,
                 "path of the control socket, for `tactus control`; a second hand's socket is PATH.2");
  app.add_flag("--view", command.view,
               "start a viewer of the run and print the address of its page; several hands: one viewer for each");
  app.add_option(
         "--hand", command.hand,
         "motion of the simulated device: script (of the scene), or pointer (the mouse on a page; at rest until then)")
      ->check(CLI::IsMember({"script", "pointer"}))
      ->capture_default_str();
  app.add_option("--pace", command.pace,
                 "pace of virtual time with --control or --view: 0.01 to 100 times real time, or 0: no limit;\n"
                 "default: 1 with --view, else 0. The results are the same bits at every pace");
}

void add_device_options(CLI::App& app, RunCommand& command) {
  Options& o = command.options;
  const std::string devices = help::devices() + "\nSeveral hands: one --device for all (sim), or one for each";
  once_or_each(app.add_option("--device", command.each.devices, devices)->default_str("sim"));
  once_or_each(
      app.add_option("--device-file", command.each.device_files,
                     std::string(help::kDeviceFile) + "; default: the scene's profile. Several hands: as --device"));
  app.add_option("--gpio", o.gpio,
                 "GPIO lines: e-stop, drive enable, probe, heartbeat, such as chip=gpiochip0,estop=3-low,enable=4");
}

void add_coupling_options_of_run(CLI::App& app, RunCommand& command) {
  Options& o = command.options;
  app.add_option("--coupling", o.coupling,
                 fmt::format("coupling scheme: {}.\n"
                             "interpolation delays the proxy by a global step; a stiffness that is unstable with\n"
                             "this delay is lowered, and the run prints it",
                             fmt::join(sim::coupling_names(), ", ")))
      ->capture_default_str();
  app.add_flag(
      "--keep-gains", o.keep_gains,
      "refuse a run in which the scene's gains are unstable, and print the limit, instead of lowering the gains");
  app.add_option(
         "--border", o.border,
         fmt::format("border of the sub-world: {}; replay is that of the paper", fmt::join(sim::border_names(), ", ")))
      ->capture_default_str();
  app.add_option("--order", o.order, help::kOrder)->capture_default_str();
  app.add_option("--reach", o.reach, "rule for the size of the boundary cube: two-cycles or paper")
      ->capture_default_str();
  app.add_option("--accuracy", o.accuracy,
                 "members and sub-steps, as multiples of the scene's: fast 0.5, balanced 1, accurate 2")
      ->capture_default_str();
  app.add_option("--rate", o.rate_Hz, std::string(help::kRate) + "; 100 to 10000")->capture_default_str();
  app.add_option("--ratio", o.ratio, std::string(help::kRatio) + "; 1 to 100; 0, the default: the scene's");
  app.add_option("--members", o.members, std::string(help::kMembers) + "; 1 to 256; 0, the default: by --accuracy");
}

void add_thread_options(CLI::App& app, RunCommand& command) {
  Options& o = command.options;
  once_or_each(
      app.add_option("--cpu", command.each.cpus, std::string(help::kCpu) + ".\nSeveral hands: one --cpu for each")
          ->check(in_range(session::kCores)));
  app.add_option("--world-threads", o.world_threads,
                 "number of threads that step the global world; 1 to 64; the results are the same bits")
      ->capture_default_str();
  app.add_option(
         "--world-precision", o.world_precision,
         "precision of the global world: double, or mixed (with more than 200 moving bodies contacts are solved in\n"
         "single precision)")
      ->capture_default_str();
  app.add_option("--world-cpu", command.world_cpus,
                 "cores of the global world, one for each of its threads, such as 2 or 1,3-4; default: any.\n"
                 "Several threads should have a core each, none of them that of the haptic thread");
  app.add_option("--priority", o.priority, std::string(help::kPriority) + "; 0 to 98")->capture_default_str();
}

void add_fault_options(CLI::App& app, RunCommand& command) {
  Options& o = command.options;
  app.add_flag("--rearm", o.rearm, "re-arm one second after a fault has latched; without this flag Enter re-arms");
  once_or_each(app.add_option(
      "--inject", command.each.injects,
      "faults to inject, as KIND@TICK[+TICKS][:AMOUNT],...; of the device: lost, late, duplicated, corrupted, nan,\n"
      "wild, teleport, frozen, unplugged, estop; of the world: stall; of the operator: reset@TICK.\n"
      "Several hands: one --inject for each; the first has the faults of the world and of the operator"));
  app.add_option("--seed", o.seed, "seed of the random numbers of injected faults")->capture_default_str();
}

}  // namespace

void add_run_options(CLI::App& app, RunCommand& command) {
  app.add_option("SCENE", command.scene,
                 "scene file, such as sim/scenes/card_house.toml; not required if --config names one");
  app.add_option(
      "--config", command.config,
      "configuration file of a deployment (`tactus config check --help`) with all options that are not given here;\n"
      "the run logs events instead of a status line");
  add_view_options(app, command);
  add_device_options(app, command);
  add_coupling_options_of_run(app, command);
  app.add_option("--duration", command.duration_s,
                 "duration of the run [s]; 0.01 to 1e6; 0, the default: until stopped; in virtual time without\n"
                 "--control and --view: 10");
  add_thread_options(app, command);
  app.add_flag("--virtual-time", command.virtual_time,
               "run in one thread on a virtual clock: the same bits every time");
  check_output(
      *app.add_option("--record", command.record,
                      "write a tape to this file, for `tactus replay`; beside my.tape, a second hand's is my.2.tape"),
      exporting::OutputKind::kTape);
  app.add_option("--budget", command.budget,
                 std::string(help::kBudget) +
                     ". The run is refused on another machine, at a higher rate, or\n"
                     "with more sub-steps than measured; its members are limited to the measured number");
  add_fault_options(app, command);
  app.add_option(
         "--figures", command.figures,
         "figures of the columns of `tactus export`, as COLUMN:HOW,..., such as force_z_N:rms; HOW is mean, rms, min,\n"
         "max, last, p99 or another percentile; in virtual time")
      ->delimiter(',');
  app.add_flag("--json", command.json, help::kJson);
}

}  // namespace tactus::tools
