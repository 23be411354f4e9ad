#include "tools/hil/device_suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <thread>

#include "hal/device_words.h"
#include "tools/caught.h"

namespace tactus::hil {
namespace {

using haptics::DeviceState;
using haptics::ReadStatus;

constexpr double kQuiet_s = 2, kPush_s = 0.3;
constexpr double kMinFresh = 0.999;  // share of the periods at rest
constexpr double kLeastFresh = 0.5;  // where times are not judged
constexpr unsigned kLongestGap = 2, kBrakePeriods = 12, kSilence = 30;
constexpr unsigned kGonePeriods = 10;  // without a sample: the loop calls that a lost link

constexpr Check kChecks[] = {
    {"identity", "the device that was opened", kNothing, nullptr},
    {"samples", "at rest: share of the periods with a new sample, longest gap", kNothing, nullptr},
    {"round-trip", "from a command to the sample that says the device has it", kNothing, nullptr},
    {"enable", "FORCE at zero force within three commands, and IDLE again", kMotors, nullptr},
    {"brake", "BRAKE is obeyed at once, and left by a re-arm's rise alone", kMotors, nullptr},
    {"not-finite", "a command with NaN: BRAKE, and the fault is named", kMotors, nullptr},
    {"watchdog", "commands stop: after how many periods it brakes; latched until a re-arm", kMotors, nullptr},
    {"force", "short pushes of --force along each axis: no fault, and the tool does not go the wrong way",
     kMotors | kForce, nullptr},
};

// Exchanges samples and commands with the device, one period after the other.
class Exchanger {
 public:
  explicit Exchanger(DeviceUnderTest& under_test) : test_(under_test) {}

  // Calls `tick(i)` between read and write of each period; without `writes` the commands are left out.
  template <class Tick>
  void run(unsigned periods, Tick&& tick, bool writes = true) {
    const auto body = [&] {
      auto deadline = std::chrono::steady_clock::now();
      const auto period = std::chrono::nanoseconds(std::llround(1e9 / test_.options.rate_Hz));
      for (unsigned i = 0; i < periods; ++i) {
        // A wake-up that is late makes no burst of reads afterwards, which would find nothing new.
        deadline = std::max(deadline + period, std::chrono::steady_clock::now());
        if (!test_.options.stepped) std::this_thread::sleep_until(deadline);
        read();
        tick(i);
        if (!writes) continue;
        if (must_end_force()) end_force();
        ++command.sequence;
        test_.device.write(command);
      }
    };
    if (test_.options.stepped) return body();
    Status thrown = Status::good();
    std::thread thread([&] {
      thrown = caught([&] {
        loop::CpuAwake awake;
        setup = loop::setup_realtime(test_.options.setup, awake);
        body();
      });
    });
    thread.join();
    if (!thrown.ok()) throw std::runtime_error(thrown.message());  // in the thread that may say so
  }
  void run(unsigned periods) {
    run(periods, [](unsigned) {});
  }
  DeviceState want(DeviceState wanted, unsigned periods) {
    command.wanted = wanted;
    run(periods);
    return input.sample.state;
  }
  void read() {
    test_.device.read(input);
    const bool is_fresh = input.status == ReadStatus::kFresh;
    fresh += is_fresh;
    silent = is_fresh ? 0 : silent + 1;
  }
  // Ten periods without a sample, as in a run.
  bool must_end_force() {
    lost = lost || (silent >= kGonePeriods && command.wanted == DeviceState::kForce);
    return lost;
  }
  void end_force() {
    command.wanted = DeviceState::kBrake;
    command.wrench = {};
  }
  // As long as a command may be on its way, its answer, and the steps of a start.
  unsigned patience() const {
    return 8 + 2 * static_cast<unsigned>(std::lround(test_.device.properties().delay_s * test_.options.rate_Hz));
  }
  void rearm() {
    command.wrench = {};
    command.rearm = 0;
    want(DeviceState::kIdle, 2);
    command.rearm = 1;
    run(2);
    command.rearm = 0;
    run(patience());
  }
  std::string silence() const {
    const std::string why = test_.trouble ? test_.trouble() : std::string();
    return "the device sends no samples, or few" + (why.empty() ? why : ": " + why);
  }
  // IDLE without fault; an empty line, or why not.
  std::string settle() {
    lost = false;
    command.wrench = {};
    command.rearm = 0;
    fresh = 0;
    if (want(DeviceState::kIdle, patience()) == DeviceState::kBrake) rearm();
    if (fresh < kLeastFresh * patience()) return silence();
    if (input.sample.state == DeviceState::kIdle && input.sample.device_fault == 0) return {};
    return fmt::format("the device is in {}; {}", hal::name_of(input.sample.state),
                       hal::describe_device_fault(input.sample.device_fault));
  }

  DeviceUnderTest& test_;
  haptics::DeviceInput input;
  haptics::DeviceCommand command;
  unsigned silent{0}, fresh{0};  // periods without a sample, in a row; those with one, counted by who resets it
  bool lost{false};              // samples did not come while FORCE was wanted; until the next settle()
  loop::SetupReport setup;
};

Finding judged(bool good, std::string measured, std::string threshold, std::string reason) {
  return {good ? Verdict::kGood : Verdict::kBad,
          std::move(measured),
          std::move(threshold),
          good ? std::string() : std::move(reason),
          {}};
}

std::string state_line(const haptics::DeviceSample& sample) {
  return fmt::format("{}{}{}", hal::name_of(sample.state), sample.device_fault != 0 ? ", " : "",
                     hal::describe_device_fault(sample.device_fault));
}

Finding check_samples(Exchanger& x) {
  const auto periods = static_cast<unsigned>(kQuiet_s * x.test_.options.rate_Hz);
  unsigned longest = 0;
  x.command.wanted = DeviceState::kIdle;
  x.silent = x.fresh = 0;
  x.run(periods, [&](unsigned) { longest = std::max(longest, x.silent); });
  const double share = x.fresh / static_cast<double>(periods);
  const bool judges = x.test_.options.judge_timing;
  const double least = judges ? kMinFresh : kLeastFresh;
  const std::string why = x.test_.trouble && share < kLeastFresh ? x.test_.trouble() : std::string();
  Finding finding = judged(share >= least && (longest <= kLongestGap || !judges),
                           fmt::format("{:.3f} % fresh of {}, longest gap {}", 100 * share, periods, longest),
                           fmt::format("{:.1f} % fresh, {}", 100 * least,
                                       judges ? fmt::format("gaps of {} at most", kLongestGap) : "gaps are not judged"),
                           "samples are missing: " + (why.empty() ? "look at the bus, its load and the host's" : why));
  finding.figures = {{"fresh_share", share}, {"longest_gap_periods", static_cast<double>(longest)}};
  return finding;
}

Finding check_round_trip(Exchanger& x) {
  std::uint64_t most = 0;
  x.run(500, [&](unsigned i) {
    if (i > 20) most = std::max(most, x.command.sequence - x.input.sample.echoed_sequence);
  });
  const auto allowed =
      1 + static_cast<std::uint64_t>(std::lround(x.test_.device.properties().delay_s * x.test_.options.rate_Hz));
  const bool judges = x.test_.options.judge_timing;
  Finding finding = judged(most <= allowed || !judges, fmt::format("{} periods at most", most),
                           fmt::format("{}: the description's delay and one{}", allowed, judges ? "" : ", not judged"),
                           "longer than described: raise transport_delay_ticks, or find what delays");
  finding.figures = {{"round_trip_periods", static_cast<double>(most)}};
  return finding;
}

Finding check_enable(Exchanger& x) {
  unsigned until_force = 0;
  x.command.wanted = DeviceState::kForce;
  x.run(x.patience(), [&](unsigned i) {
    if (until_force == 0 && x.input.sample.state == DeviceState::kForce) until_force = i;
  });
  const bool in_force = x.input.sample.state == DeviceState::kForce;
  const std::string seen = state_line(x.input.sample);
  const bool idles = x.want(DeviceState::kIdle, x.patience()) == DeviceState::kIdle;
  return judged(in_force && idles,
                fmt::format("FORCE after {} periods, then {}", until_force, state_line(x.input.sample)),
                "FORCE when it is wanted, IDLE when it is", "it was in " + seen);
}

// FORCE, from which the checks below begin; empty, or why it is not there.
std::string enter_force(Exchanger& x) {
  if (x.want(DeviceState::kForce, x.patience()) == DeviceState::kForce) return {};
  return "it is not in FORCE before: " + state_line(x.input.sample);
}

Finding check_brake(Exchanger& x) {
  if (const std::string why = enter_force(x); !why.empty()) return bad(why);
  unsigned until_brake = 0;
  x.command.wanted = DeviceState::kBrake;
  x.run(x.patience(), [&](unsigned i) {
    if (until_brake == 0 && x.input.sample.state == DeviceState::kBrake) until_brake = i;
  });
  const bool held = x.want(DeviceState::kIdle, x.patience()) == DeviceState::kBrake &&
                    x.want(DeviceState::kForce, x.patience()) == DeviceState::kBrake;
  x.rearm();
  const bool left = x.input.sample.state != DeviceState::kBrake;
  return judged(until_brake > 0 && held && left,
                fmt::format("BRAKE after {} periods, then {}", until_brake, state_line(x.input.sample)),
                "BRAKE, until a re-arm", held ? "a re-arm does not leave it" : "it does not hold");
}

Finding check_not_finite(Exchanger& x) {
  if (const std::string why = enter_force(x); !why.empty()) return bad(why);
  x.command.wrench.force.x = std::numeric_limits<double>::quiet_NaN();
  x.run(1);
  x.command.wrench = {};
  x.run(x.patience());
  const bool good = x.input.sample.state == DeviceState::kBrake && x.input.sample.device_fault != 0;
  return judged(good, state_line(x.input.sample), "BRAKE, and a fault", "the command was not refused");
}

Finding check_watchdog(Exchanger& x) {
  if (const std::string why = enter_force(x); !why.empty()) return bad(why);
  unsigned until_brake = 0;
  x.run(
      kSilence,
      [&](unsigned i) {
        if (until_brake == 0 && x.input.sample.state == DeviceState::kBrake) until_brake = i + 1;
      },
      false);
  x.want(DeviceState::kForce, x.patience());
  const bool latched = x.input.sample.state == DeviceState::kBrake;
  Finding finding = judged(until_brake > 0 && until_brake <= kBrakePeriods && latched,
                           fmt::format("brakes after {} periods, then {}", until_brake, state_line(x.input.sample)),
                           fmt::format("BRAKE within {} periods, latched", kBrakePeriods),
                           until_brake == 0 ? "it goes on without a host" : "too late, or not latched");
  finding.figures = {{"brake_periods", static_cast<double>(until_brake)}};
  return finding;
}

// What a push along one axis did.
struct Push {
  double most{0}, backwards{0};  // m, along the force and against it
  haptics::DeviceSample sample;  // the first with a fault, or else the last
};

void keep(Push& push, const haptics::DeviceSample& sample) {
  if (push.sample.device_fault == 0) push.sample = sample;
}

// All pushes in one exchange: a drive that hears nothing while a thread starts would end its force by itself.
std::array<Push, 3> push_along_axes(Exchanger& x) {
  const auto push_periods = static_cast<unsigned>(kPush_s * x.test_.options.rate_Hz);
  const unsigned rest = x.patience(), each = rest + push_periods;
  std::array<Push, 3> pushes;
  Vec3d before;
  x.command.wrench = {};
  x.command.wanted = DeviceState::kForce;
  x.run(3 * each, [&](unsigned i) {
    Push& push = pushes[i / each];
    Vec3d direction;
    direction[static_cast<int>(i / each)] = 1;
    const Vec3d& position = x.input.sample.device_from_tool.position;
    x.command.wrench = {};
    if (i % each < rest) {
      before = position;
      return;
    }
    if (x.input.sample.device_fault != 0) return keep(push, x.input.sample);
    const double share = 1 - std::abs(2.0 * (i % each - rest) / push_periods - 1);  // up and down
    x.command.wrench.force = direction * (x.test_.options.force_N * share);
    const double way = dot(position - before, direction);
    push.most = std::max(push.most, way);
    push.backwards = std::max(push.backwards, -way);
    keep(push, x.input.sample);
  });
  return pushes;
}

Finding check_force(Exchanger& x) {
  std::string measured;
  for (const Push& push : push_along_axes(x)) {
    measured += fmt::format("{}{:.2f} mm", measured.empty() ? "" : ", ", 1e3 * push.most);
    if (push.sample.device_fault != 0 || push.sample.state != DeviceState::kForce ||
        push.backwards > push.most + 2 * x.test_.device.properties().position_quantum_m)
      return judged(false, measured, "no fault, and the tool follows the force",
                    fmt::format("{:.2f} mm against the force; {}", 1e3 * push.backwards, state_line(push.sample)));
  }
  return judged(true, measured + " along x, y, z", "no fault, and the tool follows the force", "");
}

Finding run_one(Exchanger& x, const Check& check) {
  const std::string name = check.name;
  if (name == "identity") return judged(true, x.test_.identity, "opened and compared with the description", "");
  if (name == "samples") return check_samples(x);
  if (name == "round-trip") return check_round_trip(x);
  if (name == "enable") return check_enable(x);
  if (name == "brake") return check_brake(x);
  if (name == "not-finite") return check_not_finite(x);
  return name == "watchdog" ? check_watchdog(x) : check_force(x);
}

Finding run_allowed(Exchanger& x, const Check& check, const SuiteRequest& request) {
  if ((check.needs & kMotors) != 0 && !request.motors_allowed)
    return skipped("it switches the motors on: agree, or give --yes");
  if ((check.needs & kForce) != 0 && x.test_.options.force_N <= 0) return skipped("it moves the tool: give --force N");
  if (const std::string why = x.settle(); !why.empty()) return bad(why);
  Finding finding = run_one(x, check);
  for (const hal::NotChecked& one : x.test_.not_checked)
    if (one.check == check.name) finding.unseen = one.what;
  if (x.lost) {
    finding.verdict = Verdict::kBad;
    finding.reason = "the force was ended after ten periods in a row without a sample: " + x.silence();
  }
  if (const std::string why = x.settle(); !why.empty() && finding.verdict == Verdict::kGood) {
    finding.verdict = Verdict::kBad;
    finding.reason = "afterwards " + why;
  }
  return finding;
}

// IDLE, or BRAKE where it does not get there or sends nothing. Says which, and why.
std::string leave(Exchanger& x, bool motors_allowed) {
  const std::string why = x.settle();
  if (why.empty()) return hal::name_of(x.input.sample.state);
  x.want(motors_allowed ? DeviceState::kBrake : DeviceState::kIdle, x.patience());
  return fmt::format("{}: {}", hal::name_of(x.input.sample.state), why);
}

}  // namespace

std::span<const Check> device_checks() noexcept { return kChecks; }

SuiteReport run_device_suite(DeviceUnderTest& under_test, const SuiteRequest& request, const SuiteHooks& hooks) {
  SuiteReport report;
  report.real_time = !under_test.options.stepped;
  report.identity = under_test.identity;
  Exchanger exchanger(under_test);
  for (const Check& check : kChecks) {
    if (hooks.stop && hooks.stop()) break;
    if (!request.only.empty() && std::find(request.only.begin(), request.only.end(), check.name) == request.only.end())
      continue;
    if (hooks.progress) hooks.progress(check, 0);
    const auto began = std::chrono::steady_clock::now();
    CheckReport one{&check, run_allowed(exchanger, check, request), 0};
    one.took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    if (hooks.done) hooks.done(one);
    report.checks.push_back(std::move(one));
  }
  report.left_in = leave(exchanger, request.motors_allowed);
  report.setup = exchanger.setup;
  return report;
}

}  // namespace tactus::hil
