// Checks of external faults: e-stop, disconnected device, corrupt frames, bus-off.
#include <fmt/format.h>

#include <algorithm>

#include "tools/hil/check.h"
#include "tools/hil/latch.h"

namespace tactus::hil {
namespace {

using firmware::Limit;
using firmware::State;

constexpr std::uint64_t kSettleAroundFault = 100, kStay = 100;

struct Provocation {
  const char* fault;
  std::function<bool(const Record&)> sign, gone;  // detect the start and the end of the fault
  State wanted_after;                             // commanded while the fault must stay latched
};

struct Provoked {
  ExchangeResult result;
  std::optional<std::size_t> first_sign;  // index in the records
  std::string refused;                    // why it cannot be caused here
};

enum Stage : std::uint32_t { kBefore = 0, kDuring = 1, kAfter = 2, kLatched = 3, kRearm = 4, kAgain = 5 };

// Sequence: FORCE at zero force; fault on, held, off; then the latch, the re-arm, FORCE again.
Result<Provoked> provoke(Bench& bench, const Provocation& what) {
  const auto patience = static_cast<double>(bench.provoker().patience().count());
  const ExchangePhase plan[] = {{.ticks = kSettleAroundFault, .wanted = State::kForce},
                                {.ticks = bench.ticks(patience), .wanted = State::kForce},
                                {.ticks = bench.ticks(patience), .wanted = what.wanted_after},
                                {.ticks = kStay, .wanted = what.wanted_after},
                                {.ticks = kSettleAroundFault, .rearm = true},
                                {.ticks = kSettleAroundFault, .wanted = State::kForce}};
  Provoked provoked;
  bool on = false, off = false;
  std::size_t records = 0, since_sign = 0;
  const Director director = [&](const Record& record) {
    ++records;
    if (record.phase < kDuring) return Next::kGoOn;
    if (!on) {
      on = true;
      if (const Status status = bench.provoker().set(what.fault, true); !status.ok()) {
        provoked.refused = status.message();
        return Next::kStop;
      }
    }
    if (!provoked.first_sign && what.sign(record)) provoked.first_sign = records - 1;
    if (record.phase == kDuring) return provoked.first_sign && ++since_sign >= kStay ? Next::kNextPhase : Next::kGoOn;
    if (record.phase > kAfter) return Next::kGoOn;
    if (!off) {
      off = true;
      if (const Status status = bench.provoker().set(what.fault, false); !status.ok())
        provoked.refused = status.message();
    }
    return what.gone(record) ? Next::kNextPhase : Next::kGoOn;
  };
  auto result = bench.exchange(plan, director);
  if (on && !off) (void)bench.provoker().set(what.fault, false);
  if (!result.ok()) return result.status();
  provoked.result = std::move(result).value();
  return provoked;
}

// Checks the device's states after the fault, and the return to FORCE.
std::string recovery(std::span<const Record> records) {
  if (in_phases(records, kAgain, kAgain).empty()) return "it did not come back";
  return never_forced(records, kAgain);
}

// After a disconnection the device must be in BRAKE by its watchdog, or in IDLE after a restart; neither has force.
std::string safe_when_back(std::span<const Record> records) {
  for (const Record& record : in_phases(records, kLatched, kLatched))
    if (record.got == Got::kFresh && record.state.state == State::kForce)
      return "it came back in FORCE, without a re-arm";
  return {};
}

// Ticks from the last whole frame until the link reports the disconnection.
std::uint64_t ticks_to_notice(std::span<const Record> records, std::size_t first_sign) {
  for (std::size_t i = first_sign; i > 0; --i)
    if (records[i - 1].got == Got::kFresh) return first_sign - (i - 1);
  return first_sign;
}

CheckFinding away(Bench& bench, const char* fault) {
  CheckFinding finding;
  finding.threshold = "noticed, no force when it is back, FORCE again after a re-arm";
  const Provocation what{.fault = fault,
                         .sign = [](const Record& r) { return r.got == Got::kDisconnected; },
                         .gone = [](const Record& r) { return r.got == Got::kFresh; },
                         .wanted_after = State::kIdle};
  auto provoked = provoke(bench, what);
  if (!provoked.ok()) return bad(provoked.message(), finding.threshold);
  if (!provoked.value().refused.empty()) return skipped(provoked.value().refused);
  if (!provoked.value().first_sign) return bad("the link never said that the device was away", finding.threshold);
  const std::span<const Record> records = provoked.value().result.records;
  const std::uint64_t notice = ticks_to_notice(records, *provoked.value().first_sign);
  const hal::LinkCounters& link = provoked.value().result.counters;
  const auto back = std::find_if(records.begin() + static_cast<std::ptrdiff_t>(*provoked.value().first_sign),
                                 records.end(), [](const Record& r) { return r.got == Got::kFresh; });
  finding.measured =
      fmt::format("noticed after {} ticks; {} disconnects, {} errors", notice, link.disconnects, link.errors);
  if (back != records.end()) finding.measured += fmt::format("; back in {}", describe(back->state));
  finding.figures = {{"ticks_to_notice", static_cast<double>(notice)},
                     {"disconnects", static_cast<double>(link.disconnects)},
                     {"errors", static_cast<double>(link.errors)}};
  finding.reason = safe_when_back(records);
  if (finding.reason.empty()) finding.reason = recovery(records);
  if (finding.reason.empty() && link.disconnects == 0) finding.reason = "the link did not count it";
  if (!finding.reason.empty()) finding.verdict = CheckVerdict::kBad;
  return finding;
}

}  // namespace

CheckFinding check_emergency_stop(Bench& bench) {
  constexpr std::uint32_t kMaxFrames = 2;
  const auto pressed = [](const Record& r) {
    return r.got == Got::kFresh && (r.state.limits & bit_of(Limit::kEmergencyStop)) != 0;
  };
  const auto released = [&](const Record& r) { return r.got == Got::kFresh && !pressed(r); };
  CheckFinding finding;
  finding.threshold = fmt::format("BRAKE within {} frames, fault 2, latched", kMaxFrames);
  auto provoked = provoke(bench, {.fault = "estop", .sign = pressed, .gone = released, .wanted_after = State::kForce});
  if (!provoked.ok()) return bad(provoked.message(), finding.threshold);
  if (!provoked.value().refused.empty()) return skipped(provoked.value().refused);
  if (!provoked.value().first_sign)
    return bad("no state frame ever said that the e-stop is pressed", finding.threshold);
  const std::span<const Record> records = provoked.value().result.records;
  const auto frames = frames_to_brake(records, *provoked.value().first_sign);
  if (!frames) return bad("it never braked", finding.threshold);
  finding.measured = fmt::format("BRAKE, motors without effort, {} frames after the last free one", *frames);
  finding.figures.push_back({"frames_to_safe", static_cast<double>(*frames)});
  if (*frames > kMaxFrames) finding.reason = "too late";
  if (finding.reason.empty()) finding.reason = latch_broken(records, kLatched, firmware::Fault::kEmergencyStop);
  if (finding.reason.empty()) finding.reason = recovery(records);
  if (!finding.reason.empty()) finding.verdict = CheckVerdict::kBad;
  return finding;
}

CheckFinding check_unplug(Bench& bench) { return away(bench, "unplug"); }

CheckFinding check_bus_off(Bench& bench) {
  if (!bench.options().can) return skipped("not a CAN bus");
  return away(bench, "bus-off");
}

CheckFinding check_broken_states(Bench& bench) {
  // Some links discard corrupt frames: then the record has no frame, and the link's counter shows the reason.
  const auto broken = [](const Record& r) { return r.got == Got::kCorrupt || r.got == Got::kNothing; };
  const auto whole = [](const Record& r) { return r.got == Got::kFresh; };
  CheckFinding finding;
  finding.threshold = "refused and counted, whole frames after it, FORCE again";
  auto provoked = provoke(bench, {.fault = "corrupt", .sign = broken, .gone = whole, .wanted_after = State::kIdle});
  if (!provoked.ok()) return bad(provoked.message(), finding.threshold);
  if (!provoked.value().refused.empty()) return skipped(provoked.value().refused);
  FrameCounts counts;
  for (const Record& record : provoked.value().result.records) counts.add(record);
  const std::uint64_t malformed = provoked.value().result.counters.malformed;
  finding.measured = fmt::format("{} refused by their checksum, {} by the link", counts.corrupt, malformed);
  finding.figures = {{"broken", static_cast<double>(counts.corrupt)}, {"malformed", static_cast<double>(malformed)}};
  if (counts.corrupt + malformed == 0)
    finding.reason = "no frame was refused";
  else
    finding.reason = recovery(provoked.value().result.records);
  if (!finding.reason.empty()) finding.verdict = CheckVerdict::kBad;
  return finding;
}

}  // namespace tactus::hil
