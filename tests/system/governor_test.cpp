// The governor's choices in a run, and the counts that the run reports of them.
#include <bit>

#include "rt/loop/timed_tick.h"
#include "tests/system/session_bench.h"

using namespace tactus;
using namespace tactus::test;

namespace {

session::RunSummary run_on_budget(double budget) {
  auto session = make_session(scene_file("pile700.toml"), virtual_options());
  loop::GovernorConfig config = session->governor->config();
  config.budget = budget;
  *session->governor = loop::Governor(config);
  return run(*session, 300);
}

std::uint64_t ticks_with(const session::RunSummary& summary, StatusBit bit) {
  return summary.stats.status_ticks[std::countr_zero(static_cast<std::uint32_t>(bit))];
}

}  // namespace

TEST_CASE("with time to spare no tick has fewer sub-steps and no cycle fewer members") {
  const auto summary = run_on_budget(100);
  CHECK(ticks_with(summary, kSubStepsReduced) == 0);
  CHECK(ticks_with(summary, kSolverCut) == 0);
  CHECK(summary.stats.restrained_cycles == 0);
  CHECK(summary.stats.sub_steps_sum == summary.stats.ticks * summary.sub_steps);
}

TEST_CASE("with too little time ticks with fewer sub-steps and cycles with fewer members are counted") {
  const auto summary = run_on_budget(0.02);
  CHECK(ticks_with(summary, kSubStepsReduced) > 200);
  CHECK(summary.stats.restrained_cycles > summary.stats.cycles / 2);
  CHECK(summary.stats.restrained_cycles <= summary.stats.cycles + 1);  // the last has not ended
  CHECK(summary.stats.sub_steps_sum < summary.stats.ticks * summary.sub_steps);
}

TEST_CASE("a cut at a sweep is counted, and says at which") {
  auto session = make_session(scene_file("card_house.toml"), virtual_options());
  const std::uint32_t sweep = GENERATE(0u, 1u, 3u);
  run(*session, 100);
  loop::TimedTick<hal::AnyDevice, loop::NoLines, loop::VirtualClock> timed_tick(*session->driver, 0);
  timed_tick.cut_at(sweep);
  for (int tick = 0; tick < 20; ++tick) {
    timed_tick({}, [&]() noexcept { return session->operator_bits(); });
    session->count_tick();
    const loop::TickOutput& out = session->driver->output();
    REQUIRE(out.cut_sweep == sweep);
    REQUIRE((out.status & kSolverCut) != 0);
  }
  CHECK(ticks_with(session->summary(), kSolverCut) == 20);
}
