// Checks of the exchange at rest: losses, times, clocks.
#include <fmt/format.h>

#include "tools/hil/check.h"

namespace tactus::hil {
namespace {

// The device reads a command in one of its periods and acknowledges it in a state frame: two periods with
// unsynchronised clocks, one more for a slow link.
constexpr double kRoundTripPeriods = 3;
constexpr double kForceAgePeriods = 4;
// The device fades its force after three missed commands in a row.
constexpr std::uint64_t kGapTicks = 3;
constexpr double kLostShare = 1e-3;
// A crystal keeps 100 ppm; a device beyond this limit counts its periods wrongly.
constexpr double kDrift_ppm = 500;
constexpr double kPeriodShare = 0.01;

double us(std::uint64_t ns) { return static_cast<double>(ns) * 1e-3; }

void put(CheckFinding& finding, const char* name, const Histogram& h) {
  finding.figures.push_back({fmt::format("{}_p50_us", name), us(h.percentile_ns(50))});
  finding.figures.push_back({fmt::format("{}_p99_us", name), us(h.percentile_ns(99))});
  finding.figures.push_back({fmt::format("{}_p99_99_us", name), us(h.percentile_ns(99.99))});
  finding.figures.push_back({fmt::format("{}_max_us", name), us(h.max_ns())});
}

CheckFinding judge_times(Bench& bench, const Histogram& h, const char* name, double periods) {
  const double limit_us = periods * us(static_cast<std::uint64_t>(bench.period_ns()));
  CheckFinding finding;
  finding.threshold = fmt::format("p99 <= {:.0f} us ({:g} periods)", limit_us, periods);
  if (h.count() == 0) return bad("no command was ever answered", finding.threshold);
  finding.measured = fmt::format("p50 {:.0f}, p99 {:.0f}, p99.99 {:.0f}, max {:.0f} us", us(h.percentile_ns(50)),
                                 us(h.percentile_ns(99)), us(h.percentile_ns(99.99)), us(h.max_ns()));
  put(finding, name, h);
  if (us(h.percentile_ns(99)) > limit_us * 1.02) {  // 2 %: resolution of the histogram
    finding.reason = "too slow: a haptic loop would feel it";
    if (bench.options().judge_timing) finding.verdict = CheckVerdict::kBad;
  }
  return finding;
}

}  // namespace

CheckFinding judge_counts(const FrameCounts& counts, const hal::LinkCounters& link) {
  CheckFinding finding;
  finding.threshold = fmt::format("lost <= {:g} %, none unaccounted for, reordered or broken; gaps < {} ticks",
                                  100 * kLostShare, kGapTicks);
  finding.measured = fmt::format("{} frames: {} lost, {} superseded, {} reordered, {} duplicated, {} broken",
                                 counts.numbered, counts.lost(), counts.superseded, counts.reordered, counts.duplicated,
                                 counts.corrupt + link.malformed);
  finding.measured +=
      fmt::format("; {} ticks without a frame, {} in a row", counts.missing_ticks, counts.longest_gap_ticks);
  const auto put_count = [&](const char* name, std::uint64_t n) {
    finding.figures.push_back({name, static_cast<double>(n)});
  };
  put_count("frames", counts.numbered);
  put_count("ticks", counts.ticks);
  put_count("lost", counts.lost());
  put_count("superseded", counts.superseded);
  put_count("reordered", counts.reordered);
  put_count("duplicated", counts.duplicated);
  put_count("broken", counts.corrupt + link.malformed);
  put_count("missing_ticks", counts.missing_ticks);
  put_count("longest_gap_ticks", counts.longest_gap_ticks);
  put_count("commands", counts.commands);
  put_count("commands_refused", counts.refused);
  put_count("commands_superseded", link.send_superseded);
  put_count("unaccounted", counts.unaccounted(link));
  if (counts.fresh == 0)
    finding.reason = "no state frame came";
  else if (static_cast<double>(counts.lost()) > kLostShare * static_cast<double>(counts.numbered))
    finding.reason = "frames are lost on the way";
  else if (counts.unaccounted(link) > 2)
    finding.reason = fmt::format("{} frames are in no counter", counts.unaccounted(link));
  else if (counts.reordered + counts.duplicated > 0)
    finding.reason = "frames come twice or in the wrong order";
  else if (counts.corrupt + link.malformed > 0)
    finding.reason = "frames arrive broken";
  else if (counts.longest_gap_ticks >= kGapTicks)
    finding.reason = "gaps so long that the force would fade";
  else if (counts.refused > 0)
    finding.reason = fmt::format("the link did not take {} commands", counts.refused);
  if (!finding.reason.empty()) finding.verdict = CheckVerdict::kBad;
  return finding;
}

CheckFinding check_losses(Bench& bench) {
  const auto& quiet = bench.quiet();
  if (!quiet.ok()) return bad(quiet.message());
  CheckFinding finding = judge_counts(quiet.value().counts, quiet.value().result.counters);
  // A gap may be caused by this machine, if the loop was not woken; then the link is not at fault.
  const bool gap_alone = finding.reason.starts_with("gaps");
  if (gap_alone && !bench.options().judge_timing) finding.verdict = CheckVerdict::kGood;
  return finding;
}

CheckFinding check_round_trip(Bench& bench) {
  const auto& quiet = bench.quiet();
  if (!quiet.ok()) return bad(quiet.message());
  return judge_times(bench, quiet.value().times.round_trip, "round_trip", kRoundTripPeriods);
}

CheckFinding check_force_age(Bench& bench) {
  const auto& quiet = bench.quiet();
  if (!quiet.ok()) return bad(quiet.message());
  return judge_times(bench, quiet.value().times.force_age, "force_age", kForceAgePeriods);
}

CheckFinding check_clock(Bench& bench) {
  const auto& quiet = bench.quiet();
  if (!quiet.ok()) return bad(quiet.message());
  const double nominal_us = static_cast<double>(bench.period_ns()) * 1e-3;
  CheckFinding finding;
  finding.threshold =
      fmt::format("period {:g} us +- {:g} %, drift within {:g} ppm", nominal_us, 100 * kPeriodShare, kDrift_ppm);
  const auto clock = clock_figures(quiet.value().result.records);
  if (!clock) return bad("too few frames, or a device clock that stands still", finding.threshold);
  finding.measured = fmt::format("period {:.3f} us by the device, {:.3f} us by the host; drift {:+.1f} ppm",
                                 clock->device_period_us, clock->host_period_us, clock->drift_ppm);
  finding.figures = {{"device_period_us", clock->device_period_us},
                     {"host_period_us", clock->host_period_us},
                     {"drift_ppm", clock->drift_ppm}};
  const bool period_good = std::abs(clock->device_period_us - nominal_us) <= kPeriodShare * nominal_us;
  // The simulated device's clock is this program's periods: where the machine skips one, it stands still.
  const bool own_clock = bench.options().own_clock;
  const bool drift_good = std::abs(clock->drift_ppm) <= kDrift_ppm || !own_clock || !bench.options().judge_timing;
  if (!period_good) finding.reason = "the device does not keep its period by its own clock";
  if (period_good && !drift_good) finding.reason = "the two clocks go apart";
  if (!finding.reason.empty()) finding.verdict = CheckVerdict::kBad;
  return finding;
}

CheckFinding check_soak(Bench& bench) {
  const std::uint64_t frames = bench.options().soak_frames;
  const ExchangePhase plan[] = {{.ticks = frames}};
  FrameCounts counts;
  RoundTrip times;
  const auto result = bench.exchange(
      plan,
      [&](const Record& record) {
        counts.add(record);
        times.add(record);
        return Next::kGoOn;
      },
      /*keep=*/false);
  if (!result.ok()) return bad(result.message());
  CheckFinding finding = judge_counts(counts, result.value().counters);
  if (finding.reason.starts_with("gaps") && !bench.options().judge_timing) finding.verdict = CheckVerdict::kGood;
  put(finding, "round_trip", times.round_trip);
  put(finding, "force_age", times.force_age);
  return finding;
}

}  // namespace tactus::hil
