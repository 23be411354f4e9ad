// The statistics of a timing run on made-up ticks: what is counted, what is left out, which ticks are the latest.
#include "tools/timing/tick_statistics.h"

#include <catch2/catch.hpp>
#include <numeric>

#include "tests/tools/timing/made_ticks.h"
#include "tools/timing/verdict.h"

using namespace tactus;
using namespace tactus::timing;

namespace {

TickStatistics no_warm_up() { return TickStatistics({kPeriod_ns, 0, 10}); }

const VerdictRow& row(const std::vector<VerdictRow>& rows, const std::string& figure) {
  for (const auto& r : rows)
    if (r.figure == figure) return r;
  FAIL("no row " << figure);
  return rows.front();
}

}  // namespace

TEST_CASE("the stages of a tick are the times between its marks, and add up to the whole") {
  const auto t = usual_tick(7);
  const std::int64_t expected_us[kStages]{5, 10, 2, 3, 60, 120, 20};
  std::int64_t sum_ns = 0;
  for (std::uint32_t i = 0; i < kStages; ++i) {
    CHECK(duration_ns(t, static_cast<TimedStage>(i)) == 1000 * expected_us[i]);
    sum_ns += duration_ns(t, static_cast<TimedStage>(i));
  }
  CHECK(sum_ns == t.wrote_ns - t.scheduled_ns);
}

TEST_CASE("the loop's own part is neither device nor physics, and a force's age is that of its sample") {
  TickStatistics statistics = no_warm_up();
  for (std::uint64_t i = 0; i < 5; ++i) statistics.add_loop(usual_tick(i));
  CHECK(statistics.overhead.max_ns() == 2'000 + 3'000 + 4'000);  // adopt, couple, and the force's shaping
  CHECK(statistics.force_age.max_ns() == 215'000);
  CHECK(statistics.oldest_age.max_ns() == 1'215'000);  // replaced a period later
  CHECK(statistics.oldest_age.count() == 4);
}

TEST_CASE("warm-up and the first ticks after another window are not counted") {
  TickStatistics statistics({kPeriod_ns, 3, 10});
  for (std::uint64_t i = 0; i < 5; ++i) statistics.add_loop(usual_tick(i));
  CHECK(statistics.ticks == 2);
  auto first = usual_tick(5);
  first.into_window = 9;
  first.minor_faults = 7;
  statistics.add_loop(first);
  CHECK(statistics.ticks == 2);
  CHECK(statistics.minor_faults == 0);
  statistics.add_loop(usual_tick(6));
  CHECK(statistics.oldest_age.count() == 1);  // no age across the gap
}

TEST_CASE("every overrun has one cause, once the machine was looked at after it") {
  TickStatistics statistics = no_warm_up();
  for (std::uint64_t i = 0; i < 100; ++i) statistics.add_loop(usual_tick(i));
  statistics.add_look({90 * kPeriod_ns, InterruptCounts{}, 0, 0});
  statistics.add_loop(woken_late(100, 2'000'000));
  auto switched = delayed_in_solve(105, 3'000'000);
  switched.involuntary_switches = 1;
  statistics.add_loop(switched);
  auto all = [&] {
    return std::accumulate(statistics.overruns_by_cause.begin(), statistics.overruns_by_cause.end(), std::uint64_t{0});
  };
  CHECK(statistics.overruns == 2);
  CHECK(all() == 0);
  statistics.add_look({104 * kPeriod_ns, InterruptCounts{}, 0, 0});
  CHECK(all() == 1);
  statistics.finish();
  CHECK(statistics.overruns_by_cause[static_cast<std::size_t>(Cause::kLateWake)] == 1);
  CHECK(statistics.overruns_by_cause[static_cast<std::size_t>(Cause::kContextSwitch)] == 1);
  CHECK(all() == statistics.overruns);
}

TEST_CASE("the latest ticks are kept, the worst first, with those around them") {
  TickStatistics statistics = no_warm_up();
  for (std::uint64_t i = 0; i < 200; ++i)
    statistics.add_loop(i == 100   ? delayed_in_solve(i, 500'000)
                        : i == 150 ? delayed_in_solve(i, 700'000)
                                   : usual_tick(i));
  statistics.finish();
  REQUIRE(statistics.spikes.size() == TickStatistics::kWorst);
  CHECK(statistics.spikes[0].times.tick == 150);
  CHECK(statistics.spikes[1].times.tick == 100);
  CHECK(statistics.spikes[1].judged);
  REQUIRE(statistics.spikes[1].around.size() == 2 * TickStatistics::kAround + 1);
  CHECK(statistics.spikes[1].around.front().tick == 100 - TickStatistics::kAround);
  CHECK(statistics.spikes[1].around.back().tick == 100 + TickStatistics::kAround);
}

TEST_CASE("the verdict separates the program's limits from the machine's") {
  TickStatistics good = no_warm_up();
  for (std::uint64_t i = 0; i < 1000; ++i) good.add_loop(usual_tick(i));
  CHECK(verdict_of(judge(good)) == TimingVerdict::kGood);

  TickStatistics machine = good;
  for (std::uint64_t i = 1000; i < 1020; ++i) machine.add_loop(woken_late(i, 1'500'000));
  machine.finish();
  CHECK(verdict_of(judge(machine)) == TimingVerdict::kMachine);
  CHECK_FALSE(row(judge(machine), "wake-up, worst").good());

  TickStatistics faulted = good;
  auto t = usual_tick(1000);
  t.minor_faults = 1;
  faulted.add_loop(t);
  CHECK(verdict_of(judge(faulted)) == TimingVerdict::kBad);

  TickStatistics own = good;
  auto work = delayed_in_solve(1000, 1'200'000);
  work.cpu_ns += 1'200'000;
  work.predicted_ns = 1'300'000;
  own.add_loop(work);
  own.finish();
  CHECK(row(judge(own), "ticks lost to own work").measured == 1);
  CHECK(verdict_of(judge(own)) == TimingVerdict::kBad);
}
