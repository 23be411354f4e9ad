// tactus hil: the hardware-in-the-loop suite against a device on USB or CAN.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>

#include "hal/device_class.h"
#include "tools/hil/device_suite.h"
#include "tools/hil/simulated_bench.h"
#include "tools/hil/suite.h"
#include "tools/session/cores.h"
#include "tools/session/find_description.h"
#include "tools/tactus/commands.h"
#include "tools/tactus/help_texts.h"
#include "tools/tactus/hil_calibrate.h"
#include "tools/tactus/in_range.h"
#include "tools/tactus/output_option.h"
#include "tools/tactus/stop_signals.h"

namespace tactus::tools {
namespace {

constexpr double kSoak_s = 600;
constexpr std::string_view kSimulatedName = "sim";

struct HilCommand {
  hil::HilOptions options;
  std::string device, profile{"virtuose6d"}, device_file, provoke, junit, out;
  std::vector<std::string> only;
  double duration_s{0};
  std::uint64_t soak_frames{0};
  int cpu{-1}, priority{80};
  bool list{false}, yes{false}, json{false}, soak{false}, virtual_time{false}, calibrate{false};
  std::string timing{"judge"};
};

Status refused(const std::string& text) { return Status::error("tactus hil: " + text); }

Status check_command(const HilCommand& c) {
  if (c.device.empty()) return refused("--device is required; accepted: " + hal::accepted_devices());
  if (c.timing != "judge" && c.timing != "report")
    return refused(fmt::format("--timing: '{}' is none; accepted: judge, report", c.timing));
  if (!(c.options.force_N >= 0 && c.options.force_N <= 50))
    return refused(fmt::format("--force: {} is out of range; accepted: 0 to 50 N", c.options.force_N));
  if (!c.out.empty() && !c.calibrate) return refused("--out goes with --calibrate; accepted: --json, --junit FILE");
  if (!(c.duration_s >= 0 && c.duration_s <= 1e6))
    return refused(fmt::format("--duration: {} is out of range; accepted: 0 to 1e6 s", c.duration_s));
  return Status::good();
}

// Each of --soak-frames, --duration, --soak and `--only soak` requests the soak. 0: no soak.
std::uint64_t soak_frames(const HilCommand& c) {
  if (c.soak_frames > 0) return c.soak_frames;
  const bool asked = c.soak || c.duration_s > 0 || std::find(c.only.begin(), c.only.end(), "soak") != c.only.end();
  const double seconds = c.duration_s > 0 ? c.duration_s : kSoak_s;
  return asked ? static_cast<std::uint64_t>(std::llround(seconds * c.options.rate_Hz)) : 0;
}

// The checks of this class: more for a device with tactus' protocol, which has registers and frames.
std::span<const hil::Check> checks_of(const hal::DeviceClass* device_class) {
  const bool has_wire =
      device_class == nullptr || device_class->open_link != nullptr || device_class->name == kSimulatedName;
  return has_wire ? hil::all_checks() : hil::device_checks();
}

int list_checks(const HilCommand& c) {
  const auto choice = hal::choose_device(c.device);
  for (const hil::Check& check : checks_of(choice.ok() ? choice.value().device_class : nullptr))
    fmt::print("{:<18} {}\n", check.name, check.what);
  return kExitGood;
}

// The motors stay off until the operator agrees. The simulated device needs no agreement.
bool may_switch_motors_on(const HilCommand& c, bool real) {
  if (c.yes || !real) return true;
  if (isatty(STDIN_FILENO) == 0) return false;
  fmt::print(
      stderr,
      "The device's motors will be switched on, {}, and shorted again and again. Hold the tool or keep clear of\n"
      "it, and have the e-stop within reach. Type yes to go on; anything else leaves the motors off: ",
      c.options.force_N > 0 ? fmt::format("with pushes of up to {:g} N", c.options.force_N) : "at zero force");
  char line[64];
  return std::fgets(line, sizeof line, stdin) != nullptr && std::string(line) == "yes\n";
}

std::unique_ptr<hil::Provoker> make_provoker(const HilCommand& c, hil::SimulatedBench* simulated) {
  if (!c.provoke.empty()) return hil::provoke_by_command(c.provoke);
  if (simulated != nullptr) return std::make_unique<hil::ProvokeSimulated>(*simulated);
  return isatty(STDIN_FILENO) != 0 && isatty(STDERR_FILENO) != 0 ? hil::provoke_by_person() : hil::provoke_nothing();
}

int finish(const HilCommand& c, const hil::SuiteReport& report) {
  if (c.json)
    fmt::print("{}\n", to_json_text(report));
  else
    fmt::print("{}", to_text(report));
  if (!c.junit.empty()) {
    std::ofstream file(c.junit);
    file << to_junit(report);
    if (!file.flush())
      return complain_after(fmt::format("tactus hil: --junit: {} cannot be written", c.junit), kExitBadInput);
  }
  return report.good() ? kExitGood : kExitVerdictBad;
}

hil::SuiteHooks make_hooks(const HilCommand& c) {
  stop_on_signals();
  const bool terminal = isatty(STDERR_FILENO) != 0;
  hil::SuiteHooks hooks;
  // The suite ends after the check under way.
  hooks.stop = [] { return g_stop.load(std::memory_order_relaxed); };
  hooks.progress = [terminal](const hil::Check& check, double share) {
    if (terminal) fmt::print(stderr, "\r\033[K  {:<18} {:3.0f} %", check.name, 100 * share);
  };
  hooks.done = [terminal, json = c.json](const hil::CheckReport& one) {
    if (terminal) fmt::print(stderr, "\r\033[K");
    if (!json) {
      fmt::print("{}", to_line(one));
      std::fflush(stdout);
    }
  };
  return hooks;
}

int run_on_link(HilCommand& c, const hal::DeviceChoice& choice, const hal::DeviceProfile& profile,
                std::int64_t period_ns) {
  std::unique_ptr<hal::AnyLink> link;
  if (choice.device_class->open_link != nullptr) {
    auto opened = choice.device_class->open_link(
        {.address = choice.address, .profile = profile, .period_ns = period_ns, .hand = {}, .faults = {}});
    if (!opened.ok()) return complain("tactus hil: " + opened.message(), kExitMachineCannot);
    link = std::move(opened.value().link);
  } else {
    link = std::make_unique<hal::AnyLink>(std::make_unique<hil::SimulatedBench>(profile, period_ns));
  }
  const auto provoker = make_provoker(c, link->as<hil::SimulatedBench>());
  hil::Bench bench(*link, profile, *provoker, c.options);
  const hil::SuiteRequest request{c.only, may_switch_motors_on(c, choice.device_class->real)};
  hil::SuiteReport report = run_suite(bench, request, make_hooks(c));
  report.device = c.device;
  return finish(c, report);
}

int run_on_device(HilCommand& c, const hal::DeviceChoice& choice, const hal::DeviceProfile& profile,
                  std::int64_t period_ns) {
  // Drives are enabled without torque when they are opened, some families to see that their watchdog works.
  const bool allowed = may_switch_motors_on(c, choice.device_class->real);
  if (choice.device_class->real && !allowed)
    return complain("tactus hil: nothing was opened; agree, or give --yes", kExitMachineCannot);
  auto opened = choice.device_class->open(
      {.address = choice.address, .profile = profile, .period_ns = period_ns, .hand = {}, .faults = {}});
  if (!opened.ok()) return complain("tactus hil: " + opened.message(), kExitMachineCannot);
  if (const Status status = opened.value().device->start(); !status.ok())
    return complain("tactus hil: " + status.message(), kExitMachineCannot);
  hil::DeviceUnderTest under_test{.device = *opened.value().device,
                                  .identity = opened.value().identity,
                                  .options = c.options,
                                  .not_checked = opened.value().not_checked,
                                  .trouble = opened.value().trouble};
  const hil::SuiteRequest request{c.only, allowed};
  hil::SuiteReport report = run_device_suite(under_test, request, make_hooks(c));
  report.device = c.device;
  return finish(c, report);
}

// Classes that have a gain to measure.
std::string accepted_for_calibration() {
  std::string text;
  for (const hal::DeviceClass* device_class : hal::device_classes())
    if (device_class->force_gain != nullptr) text += fmt::format("{}{}", text.empty() ? "" : ", ", device_class->forms);
  return text;
}

int run_calibration(HilCommand& c, const hal::DeviceChoice& choice, const hal::DeviceProfile& profile,
                    std::int64_t period_ns) {
  const hal::DeviceClass& device_class = *choice.device_class;
  if (device_class.force_gain == nullptr)
    return complain(
        fmt::format("tactus hil: --calibrate: {} has no gain to measure; accepted: {}; for an arm of drives: "
                    "tactus device calibrate",
                    c.device, accepted_for_calibration()),
        kExitBadInput);
  if (device_class.real && !c.yes && isatty(STDIN_FILENO) == 0)
    return complain("tactus hil: --calibrate asks a person, and stdin is no terminal; give --yes for a script",
                    kExitMachineCannot);
  auto opened = device_class.open(
      {.address = choice.address, .profile = profile, .period_ns = period_ns, .hand = {}, .faults = {}});
  if (!opened.ok()) return complain("tactus hil: " + opened.message(), kExitMachineCannot);
  c.options.stepped = !device_class.real;  // a simulated device needs no clock: the calls step it
  hil::DeviceUnderTest under_test{*opened.value().device, opened.value().identity, c.options};
  return calibrate_gain({.choice = choice, .under_test = under_test, .out = c.out, .json = c.json});
}

int run_hil(HilCommand& c) {
  if (c.list) return list_checks(c);
  if (const Status status = check_command(c); !status.ok()) return complain(status.message(), kExitBadInput);
  if (const Status status = session::check_core("--cpu", c.cpu); !status.ok())
    return complain("tactus hil: " + status.message(), kExitMachineCannot);
  const auto choice = hal::choose_device(c.device);
  if (!choice.ok()) return complain("tactus hil: " + choice.message(), kExitBadInput);
  const hal::DeviceClass& device_class = *choice.value().device_class;
  if (const std::string unknown = hil::unknown_checks(c.only, checks_of(&device_class)); !unknown.empty())
    return complain(fmt::format("tactus hil: --only: {} is no check; accepted: see tactus hil --list --device {}",
                                unknown, c.device),
                    kExitBadInput);
  for (const Status& status : {c.virtual_time ? hal::check_virtual_time(device_class, c.device) : Status::good(),
                               c.device_file.empty() ? Status::good() : hal::check_described(device_class, c.device)})
    if (!status.ok()) return complain("tactus hil: " + status.message(), kExitBadInput);
  const auto profile = session::find_description(c.profile, c.device_file);
  if (!profile.ok()) return complain_of_each(profile.message(), kExitBadInput);

  c.options.stepped = c.virtual_time;
  c.options.judge_timing = c.timing == "judge";
  c.options.can = device_class.can_interfaces != nullptr;
  c.options.own_clock = device_class.real;
  c.options.soak_frames = soak_frames(c);
  c.options.setup.cpu = c.cpu;
  c.options.setup.priority = c.priority;
  const std::int64_t period_ns = std::llround(1e9 / c.options.rate_Hz);

  if (c.calibrate) return run_calibration(c, choice.value(), profile.value(), period_ns);
  if (checks_of(&device_class).data() == hil::device_checks().data())
    return run_on_device(c, choice.value(), profile.value(), period_ns);
  return run_on_link(c, choice.value(), profile.value(), period_ns);
}

void add_options(CLI::App& app, HilCommand& c) {
  app.add_option("--device", c.device, help::devices());
  app.add_option("--device-file", c.device_file, std::string(help::kDeviceFile) + "; default: --profile");
  app.add_option("--profile", c.profile, help::kProfile)->capture_default_str();
  app.add_option("--only", c.only, "checks to run, separated by commas; default: all, but the soak only with --soak")
      ->delimiter(',');
  app.add_flag("--list", c.list, "print the names of the checks and exit");
  app.add_flag("--yes", c.yes, "switch the motors on without asking");
  app.add_option("--force", c.options.force_N, "largest force that a check may command [N]; 0 to 50; default: 0");
  app.add_option(
      "--provoke", c.provoke,
      "command that causes the faults that the suite cannot cause, run as COMMAND FAULT on|off; FAULT is estop,\n"
      "unplug, corrupt or bus-off; exit status 0: done, else the check is skipped. Default: a person is asked");
  app.add_flag("--soak", c.soak, "run the soak too: ten minutes at the full rate");
  app.add_option("--duration", c.duration_s, "duration of the soak [s]; 0 to 1e6; default: 600");
  app.add_option("--soak-frames", c.soak_frames, "length of the soak in frames, instead of --duration");
  app.add_option("--rate", c.options.rate_Hz, help::kRate)
      ->check(in_range(session::kRates_Hz, "Hz"))
      ->capture_default_str();
  app.add_option("--cpu", c.cpu, "core of the thread that exchanges frames with the device; default: any")
      ->check(in_range(session::kCores));
  app.add_option("--priority", c.priority, "SCHED_FIFO priority of that thread; 0: normal scheduling")
      ->check(in_range(session::kPriorities))
      ->capture_default_str();
  app.add_option(
         "--timing", c.timing,
         "use of measured times: judge, or report (print them without a verdict, on a machine that others share)")
      ->capture_default_str();
  app.add_flag("--virtual-time", c.virtual_time,
               "run on a virtual clock, with a simulated device: the same figures every time");
  app.add_flag(
      "--calibrate", c.calibrate,
      "measure the motor values per N m of a Falcon with a kitchen scale, instead of running the checks; each push\n"
      "waits for Enter, 0.5 N first");
  app.add_option(
      "--out", c.out,
      "write the measured gain of --calibrate to [device] of this configuration file (of `tactus run --config`)");
  add_output(app, "--junit", c.junit, exporting::OutputKind::kJunit, "write the verdicts as JUnit XML to this file");
  app.add_flag("--json", c.json, help::kJson);
}

}  // namespace

CLI::App* add_hil_command(CLI::App& program, int& exit_code) {
  auto command = std::make_shared<HilCommand>();
  CLI::App* hil = program.add_subcommand("hil", "Test a device on its link: the hardware-in-the-loop suite.");
  hil->footer(
      "The suite asks before it switches the motors on, and commands zero force unless --force is given. Exit\n"
      "status: 0 good; 1 a check failed; 2 bad usage; 3 the device cannot be opened.\n\n"
      "Examples:\n"
      "  tactus hil --device usb\n"
      "  tactus hil --device can:can0 --only losses,round-trip,watchdog --yes\n"
      "  tactus hil --device sim --virtual-time --json\n"
      "  tactus hil --device falcon:nvent_firmware.bin --calibrate --out tactus.toml");
  add_options(*hil, *command);
  hil->callback([command, &exit_code] { exit_code = run_hil(*command); });
  return hil;
}

}  // namespace tactus::tools
