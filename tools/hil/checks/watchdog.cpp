// Checks of the watchdog: commands that stop, are corrupt, old or not finite; BRAKE, and the return from it.
#include <fmt/format.h>

#include <optional>

#include "tools/hil/check.h"
#include "tools/hil/latch.h"

namespace tactus::hil {
namespace {

namespace number = firmware::number;
using firmware::State;

constexpr std::uint64_t kSettle = 80, kHarm = 40;

// Watchdog settings reported by the device; defaults of the protocol if it reports none.
struct WatchdogSettings {
  std::uint32_t fade{3}, brake{10};
};
WatchdogSettings watchdog_settings(Bench& bench) {
  WatchdogSettings settings;
  if (const auto fade = bench.read(number::kFadeFrames); fade.ok()) settings.fade = fade.value();
  if (const auto brake = bench.read(number::kBrakeFrames); brake.ok()) settings.brake = brake.value();
  return settings;
}

std::string words(const Onset& onset) {
  if (!onset.at) return "never";
  const bool exact = onset.after && *onset.after + 1 == *onset.at;
  return exact || !onset.after ? fmt::format("{}", *onset.at) : fmt::format("{} to {}", *onset.after + 1, *onset.at);
}

// Sequence: FORCE at zero force, then `harmed` for long enough, then the latch and the return.
CheckFinding starve(Bench& bench, const ExchangePhase& harmed) {
  const WatchdogSettings settings = watchdog_settings(bench);
  CheckFinding finding;
  finding.threshold =
      fmt::format("fades at {} missed frames, brakes at {}, fault 1, latched", settings.fade, settings.brake);
  const ExchangePhase plan[] = {{.ticks = kSettle, .wanted = State::kForce},
                                harmed,
                                {.ticks = kSettle, .wanted = State::kForce},
                                {.ticks = kSettle, .rearm = true},
                                {.ticks = kSettle, .wanted = State::kForce}};
  const auto result = bench.exchange(plan);
  if (!result.ok()) return bad(result.message(), finding.threshold);
  const std::span<const Record> records = result.value().records;
  if (std::string reason = never_forced(records, 0); !reason.empty()) return bad(std::move(reason), finding.threshold);
  if (result.value().counters.send_failed >= kHarm && harmed.send)
    return skipped("this link takes no such command: it cannot happen on it");

  const WatchdogFigures onset = watchdog_figures(in_phases(records, 0, 1));
  finding.measured = fmt::format("fades at {}, brakes at {}", words(onset.fade), words(onset.brake));
  if (onset.fade.at) finding.figures.push_back({"frames_to_fade", static_cast<double>(*onset.fade.at)});
  if (onset.brake.at) finding.figures.push_back({"frames_to_safe", static_cast<double>(*onset.brake.at)});
  if (!onset.fade.is(settings.fade)) finding.reason = "the force does not fade when it should";
  if (!onset.brake.is(settings.brake)) finding.reason = "it does not brake when it should";
  if (finding.reason.empty()) finding.reason = latch_broken(records, 2, firmware::Fault::kCommandsLost);
  if (finding.reason.empty()) finding.reason = never_forced(records, 4);
  if (!finding.reason.empty()) finding.verdict = CheckVerdict::kBad;
  return finding;
}

}  // namespace

CheckFinding check_watchdog(Bench& bench) { return starve(bench, {.ticks = kHarm, .send = false}); }

CheckFinding check_broken_commands(Bench& bench) {
  return starve(bench, {.ticks = kHarm, .wanted = State::kForce, .harm = Harm::kBrokenCrc});
}

CheckFinding check_repeated_commands(Bench& bench) {
  return starve(bench, {.ticks = kHarm, .wanted = State::kForce, .harm = Harm::kRepeated});
}

CheckFinding check_brake(Bench& bench) {
  // When BRAKE ends, the flag is still set from the previous phase: only a new rising edge may count.
  const ExchangePhase plan[] = {{.ticks = kSettle, .wanted = State::kForce},
                                {.ticks = kSettle, .wanted = State::kBrake},
                                {.ticks = kSettle, .wanted = State::kForce},
                                {.ticks = kSettle, .rearm = true},
                                {.ticks = kSettle, .wanted = State::kForce}};
  CheckFinding finding;
  finding.threshold = "BRAKE within 3 frames, fault 0, latched";
  const auto result = bench.exchange(plan);
  if (!result.ok()) return bad(result.message(), finding.threshold);
  const std::span<const Record> records = result.value().records;
  if (std::string reason = never_forced(records, 0); !reason.empty()) return bad(std::move(reason), finding.threshold);
  const auto frames = frames_to_brake(records, kSettle + 1);  // the state frame of the requesting tick is older
  if (!frames) return bad("it never braked", finding.threshold);
  finding.measured = fmt::format("{} frames after it was asked for", *frames);
  finding.figures.push_back({"frames_to_safe", static_cast<double>(*frames)});
  if (*frames > 3) finding.reason = "it brakes too late";
  if (finding.reason.empty()) finding.reason = latch_broken(records, 2, firmware::Fault::kNone);
  if (finding.reason.empty()) finding.reason = never_forced(records, 4);
  if (!finding.reason.empty()) finding.verdict = CheckVerdict::kBad;
  return finding;
}

CheckFinding check_not_finite(Bench& bench) {
  const ExchangePhase plan[] = {{.ticks = kSettle, .wanted = State::kForce},
                                {.ticks = 1, .wanted = State::kForce, .harm = Harm::kNotFinite},
                                {.ticks = kSettle, .wanted = State::kForce},
                                {.ticks = kSettle, .rearm = true},
                                {.ticks = kSettle, .wanted = State::kForce}};
  CheckFinding finding;
  finding.threshold = "BRAKE within 3 frames, fault 4, latched";
  // On a slow host the next command can replace the one with NaN before it leaves. Where that may have happened, the
  // exchange is repeated: a device that ignores NaN is still found, because it ignores the last one too.
  constexpr int kTries = 5;
  ExchangeResult exchange;
  std::optional<std::uint64_t> frames;
  for (int i = 0; i < kTries; ++i) {
    auto result = bench.exchange(plan);
    if (!result.ok()) return bad(result.message(), finding.threshold);
    exchange = std::move(result).value();
    if (std::string reason = never_forced(exchange.records, 0); !reason.empty())
      return bad(std::move(reason), finding.threshold);
    if (exchange.counters.send_failed > 0) return skipped("this link takes no such command");
    frames = frames_to_brake(exchange.records, kSettle + 1);
    if (frames || exchange.counters.send_superseded == 0) break;
  }
  const std::span<const Record> records = exchange.records;
  if (!frames) return bad("it went on as if nothing had come", finding.threshold);
  finding.measured = fmt::format("{} frames after it was sent", *frames);
  finding.figures.push_back({"frames_to_safe", static_cast<double>(*frames)});
  if (*frames > 3) finding.reason = "it brakes too late";
  if (finding.reason.empty()) finding.reason = latch_broken(records, 2, firmware::Fault::kEffortNotFinite);
  if (finding.reason.empty()) finding.reason = never_forced(records, 4);
  if (!finding.reason.empty()) finding.verdict = CheckVerdict::kBad;
  return finding;
}

}  // namespace tactus::hil
