// The drives of the bench: a whole arm of simulated CAN drives with its mechanics and a hand, on CAN sockets.
//
//   bench_drives FILE INTERFACE[,INTERFACE] [OPTION VALUE]...     FILE: a device description with [drives]
//   --scene FILE   whose hand holds the tool       --rate HZ         steps of the mechanics a second, default 1000
//   --control FIFO commands, a line each           --priority N      SCHED_FIFO, default 90
//   --hand still   rests at the path's start       --processes each   a process for each drive, beside the mechanics
// Commands: `fault KIND AXIS PERIODS`, AXIS a number or `all`, KIND as in kFaultNames; `report`; `quit`.
// A drive answers when its command arrives, as a real one does. What happens is told as lines on standard output:
//   force period=N                              commanded torques for kSteady periods in a row
//   zero period=N after=N silent=N enabled=N    no drive has a commanded torque any more. after: periods since the last
//                                               fault began; silent: since the last command; enabled: drives
//   enabled from=N to=N period=N                so many drives are enabled
// Zero is at most half a step of the family's torque field, which has no exact zero in MIT frames.
#include <charconv>
#include <cmath>
#include <map>
#include <string_view>

#include "hal/device_file.h"
#include "rt/text/split.h"
#include "tests/vm/drive_peer.h"
#include "tests/vm/drive_processes.h"

namespace tactus::vm {
namespace {

using hal::DriveFaultKind;

constexpr unsigned kSteady = 50;
constexpr double kZeroShare = 3e-4;  // of the torque range: half a step of 12 bits, and rounding
constexpr unsigned kHandWaits = 20;  // periods in a row with all drives enabled before the hand moves

const std::map<std::string_view, DriveFaultKind> kFaultNames{{"no-answer", DriveFaultKind::kNoAnswer},
                                                             {"no-command", DriveFaultKind::kNoCommand},
                                                             {"late", DriveFaultKind::kLate},
                                                             {"twice", DriveFaultKind::kTwice},
                                                             {"foreign-id", DriveFaultKind::kForeignId},
                                                             {"undefined-id", DriveFaultKind::kUndefinedId},
                                                             {"short", DriveFaultKind::kShort},
                                                             {"fault-flag", DriveFaultKind::kFaultFlag},
                                                             {"disabled", DriveFaultKind::kDisabled},
                                                             {"restarted", DriveFaultKind::kRestarted},
                                                             {"wrapped", DriveFaultKind::kWrapped},
                                                             {"speed", DriveFaultKind::kSpeed},
                                                             {"bus-off", DriveFaultKind::kBusOff}};

struct Options {
  std::string file, interfaces, scene, control;
  unsigned rate_Hz{1000};
  int priority{90};
  bool still{false}, each{false};
};

Options read_options(int argc, char** argv) {
  if (argc < 3) fail("accepted: bench_drives FILE INTERFACE[,INTERFACE] [OPTION VALUE]...");
  Options options;
  options.file = argv[1];
  options.interfaces = argv[2];
  read_pairs(argc, argv, 3,
             {{"--scene", into(options.scene)},
              {"--control", into(options.control)},
              {"--rate", into(options.rate_Hz)},
              {"--hand", [&](const char* value) { options.still = std::string_view(value) == "still"; }},
              {"--processes", [&](const char* value) { options.each = std::string_view(value) == "each"; }},
              {"--priority", into(options.priority)}});
  if (options.rate_Hz < 100 || options.rate_Hz > 10'000) fail("--rate: accepted: 100 to 10000");
  return options;
}

std::uint64_t number_in(std::string_view text) {
  std::uint64_t number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number);
  return number;
}

// Arm: WholeArm or DriveProcesses.
template <class Arm>
class DrivesBench {
 public:
  DrivesBench(const hal::DriveDescription& drives, const std::string& control, Arm& arm)
      : drives_(drives), arm_(arm), control_(control) {}

  void run(const std::atomic<bool>& stop) {
    for (bool go_on = true; go_on && !stop.load();) {
      arm_.run_period();
      tell();
      std::string line;
      while (go_on && control_.next(line)) go_on = obey(line);
    }
  }

 private:
  // The largest commanded torque, as a share of its drive's range.
  double largest_share() {
    double worst = 0;
    for (unsigned i = 0; i < drives_.axes.size(); ++i)
      worst = std::fmax(worst, std::fabs(arm_.law(i).commanded_Nm()) / drives_.axes[i].torque_range_Nm);
    return worst;
  }

  void tell() {
    unsigned enabled = 0;
    for (unsigned i = 0; i < drives_.axes.size(); ++i) enabled += arm_.law(i).enabled ? 1u : 0u;
    const double share = largest_share();
    const auto n = [](std::uint64_t number) { return static_cast<unsigned long long>(number); };
    const std::uint64_t period = arm_.periods();
    if (enabled != enabled_) std::printf("enabled from=%u to=%u period=%llu\n", enabled_, enabled, n(period));
    if (share <= kZeroShare && pushes_ > 0)
      std::printf("zero period=%llu after=%llu silent=%llu enabled=%u\n", n(period), n(period - fault_),
                  n(arm_.silent_periods()), enabled);
    pushes_ = share > kZeroShare ? pushes_ + 1 : 0;
    if (pushes_ == kSteady) std::printf("force period=%llu\n", n(period));
    largest_share_ = std::fmax(largest_share_, share);
    largest_rise_ = std::fmax(largest_rise_, share - share_);
    share_ = share;
    enabled_ = enabled;
    all_enabled_ = enabled == drives_.axes.size() ? all_enabled_ + 1 : 0;
    if (!hand_moves_) arm_.restart_hand();
    hand_moves_ = hand_moves_ || all_enabled_ >= kHandWaits;
  }

  bool obey(const std::string& line) {
    if (line == "quit") return false;
    if (line.starts_with("fault "))
      inject(line);
    else if (line == "report")
      report();
    else
      fail("unknown command '" + line + "'");
    std::printf("done %s\n", line.c_str());
    return true;
  }

  void inject(const std::string& line) {
    const std::size_t first = line.find(' ') + 1, second = line.find(' ', first), third = line.find(' ', second + 1);
    if (second == std::string::npos || third == std::string::npos) fail("accepted: fault KIND AXIS PERIODS");
    const auto kind = kFaultNames.find(std::string_view(line).substr(first, second - first));
    if (kind == kFaultNames.end()) fail("no such fault: " + line);
    const std::string axis = line.substr(second + 1, third - second - 1);
    arm_.inject({.kind = kind->second,
                 .axis = axis == "all" ? hal::kAllAxes : static_cast<unsigned>(number_in(axis)),
                 .ticks = number_in(line.substr(third + 1))});
    fault_ = arm_.periods();
  }

  void report() {
    std::printf("report periods=%llu share=%g largest_share=%g largest_rise=%g enabled=%u not_sent=%u lost=%u z_m=%g\n",
                static_cast<unsigned long long>(arm_.periods()), share_ > kZeroShare ? share_ : 0.0, largest_share_,
                std::exchange(largest_rise_, 0.0), enabled_, arm_.not_sent(), arm_.lost(),
                arm_.plant().pose().position.z);
  }

  hal::DriveDescription drives_;
  Arm& arm_;
  ControlLines control_;
  std::uint64_t fault_{0}, pushes_{0}, all_enabled_{0};
  unsigned enabled_{0};
  double share_{0}, largest_share_{0}, largest_rise_{0};
  bool hand_moves_{false};
};

int run(const Options& options) {
  const auto profile = hal::load_device_file(options.file);
  if (!profile.ok()) fail(profile.message());
  if (profile.value().description.drives.empty()) fail(options.file + " has no [drives]");
  const hal::HandModel hand =
      options.scene.empty() ? hal::HandModel() : hand_of(read_scene(options.scene), options.still);
  const auto serve_arm = [&](auto&& arm) {
    DrivesBench bench(profile.value().description.drives, options.control, arm);
    return serve(bench, options.priority);
  };
  const unsigned period_us = 1'000'000 / options.rate_Hz;
  const auto interfaces = text::split(options.interfaces, ',');
  if (options.each) return serve_arm(DriveProcesses(profile.value(), hand, period_us, interfaces, options.priority));
  return serve_arm(WholeArm(profile.value(), hand, period_us, interfaces));
}

}  // namespace
}  // namespace tactus::vm

int main(int argc, char** argv) { return tactus::vm::run(tactus::vm::read_options(argc, argv)); }
