// The verdict on a timing run has the rules of a run in it, not rules of its own.
#include "tools/timing/verdict.h"

#include <catch2/catch.hpp>

#include "tests/tools/timing/made_ticks.h"
#include "tools/session/summary.h"
#include "tools/timing/report.h"

using Catch::Matchers::Contains;

using namespace tactus;
using namespace tactus::timing;

namespace {

std::vector<VerdictRow> rows_with(const session::RunSummary& summary) {
  return rows_of(session::judge_simulation(summary));
}

}  // namespace

TEST_CASE("a simulation that is bad makes a timing run bad, one that is degraded makes it no good") {
  session::RunSummary summary;
  summary.real_time = summary.has_global = true;
  summary.stats.ticks = 1000;
  summary.stats.cycles = 100;
  summary.ratio = 10;
  CHECK(verdict_of(rows_with(summary)) == TimingVerdict::kGood);
  summary.global.overlap = {0.2, 1e-3, 3, 7};
  CHECK(verdict_of(rows_with(summary)) == TimingVerdict::kMachine);
  summary.global.overlap.share = 0.6;
  CHECK(verdict_of(rows_with(summary)) == TimingVerdict::kBad);
  summary.global.overlap = {};
  summary.scene_problems = {"bodies 1 and 2 overlap"};
  CHECK(verdict_of(rows_with(summary)) == TimingVerdict::kBad);
}

TEST_CASE("a line of the set-up that says FAIL, the kernel's too, is no good timing run") {
  session::RunSummary summary;
  summary.real_time = true;
  loop::SetupStep kernel;
  kernel.name = "kernel";
  kernel.ok = false;
  REQUIRE(summary.setup.steps.try_push(kernel));
  CHECK(verdict_of(rows_with(summary)) == TimingVerdict::kMachine);
  CHECK(session::judge(summary).level() == session::Level::kDegraded);
}

TEST_CASE("the report's verdict says in words what a rule of a run found") {
  TimingResult r{.statistics = TickStatistics({kPeriod_ns, 0, 10})};
  for (std::uint64_t i = 0; i < 400; ++i) r.statistics.add_loop(usual_tick(i));
  r.statistics.finish();
  r.summary.has_global = true;
  r.summary.global.overlap = {0.2, 1e-3, 3, 7};
  r.rows = rows_with(r.summary);
  CHECK_THAT(to_text(r), Contains("bodies 3 and 7 overlapped by 1.00 mm, 20 %") && Contains("degraded\n"));
}

TEST_CASE("the report's verdict names the figure that is beyond its limit, and the limit") {
  TimingResult r{.statistics = TickStatistics({kPeriod_ns, 0, 10})};
  for (std::uint64_t i = 0; i < 400; ++i) r.statistics.add_loop(i == 200 ? woken_late(i, 900'000) : usual_tick(i));
  r.statistics.finish();
  r.rows = judge(r.statistics);
  CHECK_THAT(to_text(r), Contains("THE MACHINE: wake-up, worst 905.0, at most 500.0 us; the program lost no tick"));
}

TEST_CASE("deadlines are judged by the same figure as in a run") {
  TickStatistics statistics({kPeriod_ns, 0, 10});
  for (std::uint64_t i = 0; i < 400; ++i) statistics.add_loop(i == 200 ? woken_late(i, 1'500'000) : usual_tick(i));
  statistics.finish();
  for (const VerdictRow& row : judge(statistics))
    if (row.figure == "after their deadline") CHECK(row.limit == session::most_lost_of_10000(statistics.ticks));
}
