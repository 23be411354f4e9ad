// tactus timing: measures the real loop in a worst-case scene, stage by stage.
#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "hal/device_class.h"
#include "tools/doctor/examine.h"
#include "tools/json_report.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/help_texts.h"
#include "tools/tactus/in_range.h"
#include "tools/tactus/output_option.h"
#include "tools/tactus/stop_signals.h"
#include "tools/tactus/timed_viewer.h"
#include "tools/timing/budget.h"
#include "tools/timing/report.h"
#include "tools/timing/trace.h"
#include "tools/version/provenance.h"

namespace tactus::tools {
namespace {

struct TimingCommand {
  timing::TimingOptions options;
  std::string load{"none"}, against, svg, trace, certify;
  bool no_bare{false}, json{false}, strict{false};
};

void show_progress(double share, const session::LiveStatus& live) {
  fmt::print(stderr, "\r\033[K{:3.0f} %  members {:3}  contacts {:4}  border {:4}  overruns {}", 100 * share,
             live.members.load(std::memory_order_relaxed), live.contacts.load(std::memory_order_relaxed),
             live.border.load(std::memory_order_relaxed), live.overruns.load(std::memory_order_relaxed));
}

int certify(const TimingCommand& command, const timing::TimingResult& result) {
  if (command.certify.empty()) return kExitGood;
  const std::string text = timing::budget_text(result, timing::this_machine(result.options.run.cpu));
  if (text.empty())
    return complain("tactus timing: --certify: the verdict is bad, nothing is signed off", kExitVerdictBad);
  if (result.verdict() != timing::TimingVerdict::kGood)
    (void)complain("tactus timing: --certify: signed off as it was, not good: `tactus run --budget` refuses it",
                   kExitGood);
  return write_file(command.certify, text);
}

// The doctor's findings that make figures of this PC unrepresentative of a dedicated one.
std::vector<std::string> distortions(int cpu, double rate_Hz) {
  const auto system = doctor::SystemView::open("/");
  std::vector<std::string> found;
  if (!system.ok()) return found;
  doctor::Request request;
  request.cpu = cpu;
  request.rate_Hz = rate_Hz;
  for (const doctor::MachineFinding& finding : doctor::examine(system.value(), request).findings)
    if (finding.distorts) found.push_back(finding.check + ": " + finding.found);
  return found;
}

void print_result(const timing::TimingResult& result, bool json) {
  const auto distorted = distortions(result.options.run.cpu, result.options.run.rate_Hz);
  if (json) {
    auto object = to_json(result);
    object["representative"] = distorted.empty();
    fmt::print("{}\n", report_text(object, 2));
    return;
  }
  fmt::print("{}", to_text(result));
  if (!distorted.empty()) fmt::print("these figures are NOT representative of a dedicated real-time PC:\n");
  for (const std::string& line : distorted) fmt::print("  {}\n", line);
}

// The command line that repeats the measurement.
std::string command_of(const TimingCommand& command, int cpu) {
  const timing::TimingOptions& o = command.options;
  std::string text =
      fmt::format("tactus timing --duration {:g} --rate {:g} --cpu {} --priority {} --ratio {} --load {}", o.duration_s,
                  o.run.rate_Hz, cpu, o.run.priority, o.ratio, command.load);
  if (o.run.device != "sim") text += " --device " + shell_word(o.run.device);
  if (!o.run.device_file.empty()) text += " --device-file " + shell_word(o.run.device_file.string());
  text += o.run.scene.empty() ? fmt::format(" --members {} --sub-steps {}", o.members, o.sub_steps)
                              : " --scene " + shell_word(o.run.scene.string());
  if (command.no_bare) text += " --no-bare";
  if (o.os_noise) text += " --os-noise";
  if (!command.against.empty()) text += " --against " + shell_word(command.against);
  if (o.with_viewer) text += fmt::format(" --with-viewer --window {:g}", o.window_s);
  return text + " --svg " + shell_word(command.svg);
}

int run_timing_command(TimingCommand& command) {
  timing::TimingOptions& o = command.options;
  const auto load = timing::parse_load(command.load);
  if (!load.ok()) return complain("tactus timing: " + load.message(), kExitBadInput);
  o.load = load.value();
  o.bare = !command.no_bare;
  o.against_cyclictest = !command.against.empty();
  if (o.run.scene.empty()) o.run.members = o.members;
  if (const Status status = timing::check(o); !status.ok())
    return complain("tactus timing: " + status.message(), kExitBadInput);
  if (o.with_viewer && !command.certify.empty())
    return complain("tactus timing: --certify: signs a run without a viewer off; accepted: without --with-viewer",
                    kExitBadInput);
  TimedViewer viewer;
  if (o.with_viewer)
    if (const Status status = viewer.open(); !status.ok())
      return complain("tactus timing: --with-viewer: " + status.message(), kExitMachineCannot);
  stop_on_signals();
  const bool terminal = isatty(STDERR_FILENO) != 0;
  timing::TimingProblem problem;
  const auto result =
      timing::run_timing(o, terminal ? show_progress : timing::TimingProgress{}, g_stop, problem, viewer.watcher());
  if (terminal) fmt::print(stderr, "\r\033[K");
  if (!result) return complain("tactus timing: " + problem.text, problem.input ? kExitBadInput : kExitMachineCannot);
  if (result->statistics.ticks == 0)
    return complain("tactus timing: stopped before a tick was measured", kExitMachineCannot);
  print_result(*result, command.json);
  for (const int failed :
       {write_file(command.svg, timing::to_svg(*result, provenance(command_of(command, result->options.run.cpu)))),
        command.trace.empty() ? kExitGood : write_file(command.trace, timing::trace_json(result->statistics)),
        certify(command, *result)})
    if (failed != kExitGood) return failed;
  const timing::TimingVerdict verdict = result->verdict();
  const bool bad =
      verdict == timing::TimingVerdict::kBad || (command.strict && verdict != timing::TimingVerdict::kGood);
  return bad ? kExitVerdictBad : kExitGood;
}

}  // namespace

CLI::App* add_timing_command(CLI::App& program, int& exit_code) {
  auto command = std::make_shared<TimingCommand>();
  timing::TimingOptions& o = command->options;
  CLI::App* app = program.add_subcommand(
      "timing", "Measure the times of the haptic loop at its capacity, by stage, on a device or a simulated one.");
  app->footer(
      "Stages: wake (from the deadline until the thread runs), read (the device or its model), adopt (guard,\n"
      "snapshot, report), couple, collide (up to the first sweep), solve, write (passivity, limits, the device).\n"
      "Windows of the loop and of a bare timer alternate, to show the loop's own share of a late wake-up.\n"
      "Exit status: 0 no tick was lost to the program's own work; 1 a tick was lost, a page fault occurred, or the\n"
      "simulation went wrong by the rules of `tactus run`; with --strict also if the machine did not keep up or the\n"
      "run is degraded; 2 bad usage or scene; 3 the machine cannot do it.\n\n"
      "Examples:\n"
      "  tactus timing --cpu 3 --duration 600 --load stress-ng --svg timing.svg --trace timing.json\n"
      "  tactus timing --cpu 3 --against cyclictest --duration 600\n"
      "  tactus timing --cpu 3 --with-viewer --duration 60\n"
      "  tactus timing --cpu 3 --members 100 --duration 3600 --load memory --certify budget.json");
  app->add_option("--duration", o.duration_s, "duration of all windows together [s]; 3 to 1e6")->capture_default_str();
  app->add_option("--members", o.members, std::string(help::kMembers) + ": the declared capacity")
      ->check(in_range(2u, haptics::kMaxMembers))
      ->capture_default_str();
  app->add_option("--sub-steps", o.sub_steps, "sub-steps per tick: the declared capacity")
      ->check(in_range(1u, 16u))
      ->capture_default_str();
  app->add_option("--ratio", o.ratio, help::kRatio)->check(in_range(session::kRatios))->capture_default_str();
  app->add_option("--scene", o.run.scene, "scene file to time at its own capacity, instead of the built-in worst case");
  app->add_option("--device", o.run.device,
                  help::devices() + "\nA real device is timed without force, and without the bare timer")
      ->capture_default_str();
  app->add_option("--device-file", o.run.device_file,
                  std::string(help::kDeviceFile) + "; default: the scene's profile");
  app->add_option("--rate", o.run.rate_Hz, help::kRate)
      ->check(in_range(session::kRates_Hz, "Hz"))
      ->capture_default_str();
  app->add_option("--cpu", o.run.cpu, help::kCpu)->check(in_range(session::kCores));
  app->add_option("--priority", o.run.priority, help::kPriority)
      ->check(in_range(session::kPriorities))
      ->capture_default_str();
  app->add_option("--load", command->load, "load on the other cores: none, cpu, memory, stress-ng")
      ->capture_default_str();
  app->add_option("--window", o.window_s, "length of a window of the loop, and of the bare timer [s]; 0.1 to 3600")
      ->capture_default_str();
  app->add_flag("--no-bare", command->no_bare, "run the loop all the time, without windows of the bare timer");
  app->add_flag(
      "--os-noise", o.os_noise,
      "name what ran on the core when a tick was late, from the kernel's osnoise events. Needs root. On kernels\n"
      "before 6.2 this wakes a kernel thread on the measured core once a second");
  app->add_option(
         "--against", command->against,
         "program that runs in place of the bare timer: cyclictest (Debian: rt-tests), in turns with the loop, 10 s\n"
         "each, on the same core, at the same period and priority")
      ->check(CLI::IsMember({"cyclictest"}));
  app->add_flag(
         "--with-viewer", o.with_viewer,
         "watch every second window with `tactus view` and a page that takes all frames, in place of the bare timer;\n"
         "print the ratios of wake-up and of a tick's own part, p50 and p99")
      ->excludes("--no-bare");
  using enum exporting::OutputKind;
  add_output(*app, "--svg", command->svg, kSvg, "plot the times in this SVG file");
  add_output(*app, "--trace", command->trace, kTrace,
             "write a trace of the worst spikes and of the last second to this file, for Perfetto");
  add_output(*app, "--certify", command->certify, kBudget,
             "write the measured capacity to this budget file, for `tactus run --budget`");
  app->add_flag("--strict", command->strict,
                "return exit status 1 also if the machine did not keep up or the run is degraded");
  app->add_flag("--json", command->json, help::kJson);
  app->callback([command, &exit_code] { exit_code = run_timing_command(*command); });
  return app;
}

}  // namespace tactus::tools
