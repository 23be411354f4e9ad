#include "tools/timing/verdict.h"

#include <algorithm>

namespace tactus::timing {

// Limits, as shares of the period. Wake-up: jitter of a tenth of a period is not perceptible; a delay of half a period
// leaves less computing time than the governor assumes. Computing: 0.6, the governor's budget, and 0.85, where the
// solver is cut. Done: 1 tick in 10 000 after its deadline, when the force is held one period longer. Force age: one
// period when replaced, two after one late tick. The loop's own part: a hundredth of a period.
std::vector<VerdictRow> judge(const TickStatistics& b) {
  const double period_us = static_cast<double>(b.settings().period_ns) * 1e-3;
  const auto own = b.overruns_by_cause[static_cast<std::size_t>(Cause::kOwnWork)];
  const double ticks = b.ticks > 0 ? static_cast<double>(b.ticks) : 1;
  const Histogram& wake = b.stages[static_cast<std::size_t>(TimedStage::kWake)];
  // Figure, unit, measured, limit, ours.
  return {
      {"ticks lost to own work", "", static_cast<double>(own), 0, true},
      {"page faults", "", static_cast<double>(b.minor_faults + b.major_faults), 0, true},
      {"wake-up, p99", "us", us(wake.percentile_ns(99)), 0.1 * period_us, false},
      {"wake-up, worst", "us", us(wake.max_ns()), 0.5 * period_us, false},
      {"computing, p99", "us", us(b.compute.percentile_ns(99)), 0.6 * period_us, false},
      {"computing, p99.99", "us", us(b.compute.percentile_ns(99.99)), 0.85 * period_us, false},
      {"the loop's own part, p50", "us", us(b.overhead.percentile_ns(50)), 0.01 * period_us, false},
      {"after their deadline", "of 10000", 1e4 * static_cast<double>(b.overruns) / ticks,
       session::most_lost_of_10000(b.ticks), false},
      {"force age, p99.99", "us", us(b.oldest_age.percentile_ns(99.99)), 2 * period_us, false},
      {"context switches", "", static_cast<double>(b.involuntary_switches), 0, false},
  };
}

std::vector<VerdictRow> rows_of(const std::vector<session::RunRuling>& rulings) {
  std::vector<VerdictRow> rows;
  for (const session::RunRuling& r : rulings) {
    const bool bad = r.level() == session::Level::kBad;
    rows.push_back({.figure = r.figure,
                    .unit = r.unit,
                    .measured = r.measured,
                    .limit = std::min(r.degraded_above, r.bad_above),
                    .ours = bad,
                    .found = r.level() == session::Level::kGood ? "" : r.found});
  }
  return rows;
}

TimingVerdict verdict_of(const std::vector<VerdictRow>& rows) {
  TimingVerdict verdict = TimingVerdict::kGood;
  for (const VerdictRow& row : rows) {
    if (row.good()) continue;
    if (row.ours) return TimingVerdict::kBad;
    verdict = TimingVerdict::kMachine;
  }
  return verdict;
}

const char* name_of(TimingVerdict verdict) {
  switch (verdict) {
    case TimingVerdict::kGood:
      return "good";
    case TimingVerdict::kMachine:
      return "machine";
    case TimingVerdict::kBad:
      return "bad";
  }
  return "";
}

}  // namespace tactus::timing
