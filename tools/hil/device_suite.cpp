#include "tools/hil/device_suite.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <limits>

#include "hal/device_words.h"
#include "tools/hil/device_exchange.h"

namespace tactus::hil {
namespace {

using haptics::DeviceState;
using haptics::ReadStatus;

constexpr double kQuiet_s = 2, kPush_s = 0.3;
constexpr double kMinFresh = 0.999;  // share of the periods at rest
constexpr unsigned kLongestGap = 2, kBrakePeriods = 12, kSilence = 30;

// Name, what is checked, what the check needs. The functions are null: run_one calls each check by its name.
constexpr Check kDeviceChecks[] = {
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

CheckFinding judged(bool good, std::string measured, std::string threshold, std::string reason) {
  return {.verdict = good ? CheckVerdict::kGood : CheckVerdict::kBad,
          .measured = std::move(measured),
          .threshold = std::move(threshold),
          .reason = good ? std::string() : std::move(reason),
          .figures = {}};
}

std::string state_line(const haptics::DeviceSample& sample) {
  return fmt::format("{}{}{}", hal::name_of(sample.state), sample.device_fault != 0 ? ", " : "",
                     hal::describe_device_fault(sample.device_fault));
}

CheckFinding check_samples(DeviceExchange& x) {
  const auto periods = static_cast<unsigned>(kQuiet_s * x.test.options.rate_Hz);
  unsigned longest = 0;
  x.command.wanted = DeviceState::kIdle;
  x.silent = x.fresh = 0;
  x.run(periods, [&](unsigned) { longest = std::max(longest, x.silent); });
  const double share = x.fresh / static_cast<double>(periods);
  const bool judges = x.test.options.judge_timing;
  const double least = judges ? kMinFresh : DeviceExchange::kLeastFresh;
  const std::string why = x.test.trouble && share < DeviceExchange::kLeastFresh ? x.test.trouble() : std::string();
  CheckFinding finding =
      judged(share >= least && (longest <= kLongestGap || !judges),
             fmt::format("{:.3f} % fresh of {}, longest gap {}", 100 * share, periods, longest),
             fmt::format("{:.1f} % fresh, {}", 100 * least,
                         judges ? fmt::format("gaps of {} at most", kLongestGap) : "gaps are not judged"),
             "samples are missing: " + (why.empty() ? "look at the bus, its load and the host's" : why));
  finding.figures = {{"fresh_share", share}, {"longest_gap_periods", static_cast<double>(longest)}};
  return finding;
}

CheckFinding check_round_trip(DeviceExchange& x) {
  std::uint64_t most = 0;
  x.run(500, [&](unsigned i) {
    if (i > 20) most = std::max(most, x.command.sequence - x.input.sample.echoed_sequence);
  });
  const auto allowed =
      1 + static_cast<std::uint64_t>(std::lround(x.test.device.properties().delay_s * x.test.options.rate_Hz));
  const bool judges = x.test.options.judge_timing;
  CheckFinding finding =
      judged(most <= allowed || !judges, fmt::format("{} periods at most", most),
             fmt::format("{}: the description's delay and one{}", allowed, judges ? "" : ", not judged"),
             "longer than described: raise transport_delay_ticks, or find what delays");
  finding.figures = {{"round_trip_periods", static_cast<double>(most)}};
  return finding;
}

CheckFinding check_enable(DeviceExchange& x) {
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
std::string enter_force(DeviceExchange& x) {
  if (x.want(DeviceState::kForce, x.patience()) == DeviceState::kForce) return {};
  return "it is not in FORCE before: " + state_line(x.input.sample);
}

CheckFinding check_brake(DeviceExchange& x) {
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

CheckFinding check_not_finite(DeviceExchange& x) {
  if (const std::string why = enter_force(x); !why.empty()) return bad(why);
  x.command.wrench.force.x = std::numeric_limits<double>::quiet_NaN();
  x.run(1);
  x.command.wrench = {};
  x.run(x.patience());
  const bool good = x.input.sample.state == DeviceState::kBrake && x.input.sample.device_fault != 0;
  return judged(good, state_line(x.input.sample), "BRAKE, and a fault", "the command was not refused");
}

CheckFinding check_watchdog(DeviceExchange& x) {
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
  CheckFinding finding =
      judged(until_brake > 0 && until_brake <= kBrakePeriods && latched,
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

// All pushes are in one exchange: a drive that receives no command while a thread starts ends its force by itself.
std::array<Push, 3> push_along_axes(DeviceExchange& x) {
  const auto push_periods = static_cast<unsigned>(kPush_s * x.test.options.rate_Hz);
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
    x.command.wrench.force = direction * (x.test.options.force_N * share);
    const double way = dot(position - before, direction);
    push.most = std::max(push.most, way);
    push.backwards = std::max(push.backwards, -way);
    keep(push, x.input.sample);
  });
  return pushes;
}

CheckFinding check_force(DeviceExchange& x) {
  std::string measured;
  for (const Push& push : push_along_axes(x)) {
    measured += fmt::format("{}{:.2f} mm", measured.empty() ? "" : ", ", 1e3 * push.most);
    if (push.sample.device_fault != 0 || push.sample.state != DeviceState::kForce ||
        push.backwards > push.most + 2 * x.test.device.properties().position_quantum_m)
      return judged(false, measured, "no fault, and the tool follows the force",
                    fmt::format("{:.2f} mm against the force; {}", 1e3 * push.backwards, state_line(push.sample)));
  }
  return judged(true, measured + " along x, y, z", "no fault, and the tool follows the force", "");
}

CheckFinding run_one(DeviceExchange& x, const Check& check) {
  const std::string name = check.name;
  if (name == "identity") return judged(true, x.test.identity, "opened and compared with the description", "");
  if (name == "samples") return check_samples(x);
  if (name == "round-trip") return check_round_trip(x);
  if (name == "enable") return check_enable(x);
  if (name == "brake") return check_brake(x);
  if (name == "not-finite") return check_not_finite(x);
  return name == "watchdog" ? check_watchdog(x) : check_force(x);
}

CheckFinding run_allowed(DeviceExchange& x, const Check& check, const SuiteRequest& request) {
  if ((check.needs & kMotors) != 0 && !request.motors_allowed)
    return skipped("it switches the motors on: agree, or give --yes");
  if ((check.needs & kForce) != 0 && x.test.options.force_N <= 0) return skipped("it moves the tool: give --force N");
  if (const std::string why = x.settle(); !why.empty()) return bad(why);
  CheckFinding finding = run_one(x, check);
  for (const hal::NotChecked& one : x.test.not_checked)
    if (one.check == check.name) finding.unseen = one.what;
  if (x.lost) {
    finding.verdict = CheckVerdict::kBad;
    finding.reason = "the force was ended after ten periods in a row without a sample: " + x.silence();
  }
  if (const std::string why = x.settle(); !why.empty() && finding.verdict == CheckVerdict::kGood) {
    finding.verdict = CheckVerdict::kBad;
    finding.reason = "afterwards " + why;
  }
  return finding;
}

// IDLE, or BRAKE where it does not get there or sends nothing. Says which, and why.
std::string leave(DeviceExchange& x, bool motors_allowed) {
  const std::string why = x.settle();
  if (why.empty()) return hal::name_of(x.input.sample.state);
  x.want(motors_allowed ? DeviceState::kBrake : DeviceState::kIdle, x.patience());
  return fmt::format("{}: {}", hal::name_of(x.input.sample.state), why);
}

}  // namespace

std::span<const Check> device_checks() noexcept { return kDeviceChecks; }

SuiteReport run_device_suite(DeviceUnderTest& under_test, const SuiteRequest& request, const SuiteHooks& hooks) {
  SuiteReport report;
  report.real_time = !under_test.options.stepped;
  report.identity = under_test.identity;
  DeviceExchange exchange(under_test);
  for (const Check& check : kDeviceChecks) {
    if (hooks.stop && hooks.stop()) break;
    if (!request.only.empty() && std::find(request.only.begin(), request.only.end(), check.name) == request.only.end())
      continue;
    if (hooks.progress) hooks.progress(check, 0);
    const auto began = std::chrono::steady_clock::now();
    CheckReport one{&check, run_allowed(exchange, check, request), 0};
    one.took_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    if (hooks.done) hooks.done(one);
    report.checks.push_back(std::move(one));
  }
  report.left_in = leave(exchange, request.motors_allowed);
  report.setup = exchange.setup;
  return report;
}

}  // namespace tactus::hil
