// The probe: its windows, its records, and the stages that a tick reports.
#include "rt/loop/tick_probe.h"

#include <catch2/catch.hpp>
#include <vector>

#include "rt/base/clock.h"
#include "tests/rt/loop/haptic_loop_bench.h"

using namespace tactus;
using namespace tactus::loop;

namespace {

struct Record {
  std::uint32_t kind;
  TickTimes times;
};

std::vector<Record> drained(TickProbe& probe) {
  std::vector<Record> records;
  RingRecord header;
  TickTimes times;
  while (probe.ring().try_pop(header, std::as_writable_bytes(std::span<TickTimes, 1>(&times, 1))) == Pop::kRecord)
    records.push_back({header.kind, times});
  return records;
}

}  // namespace

TEST_CASE("windows alternate and give how far into them a deadline is") {
  const WindowPlan plan{100, 50, 20};
  CHECK(plan.at(0) == WindowKind::kLoop);
  CHECK(plan.at(99) == WindowKind::kLoop);
  CHECK(plan.at(100) == WindowKind::kBare);
  CHECK(plan.at(150) == WindowKind::kRest);
  CHECK(plan.at(170) == WindowKind::kLoop);
  CHECK(plan.into(175) == 5);
  CHECK(plan.into(149) == 49);
  CHECK(plan.left(149) == 1);
  CHECK(plan.left(150) == 20);
  const WindowPlan loop_only{100, 0, 0};
  CHECK(loop_only.at(12345) == WindowKind::kLoop);
  CHECK(loop_only.into(12345) == 12345);
}

TEST_CASE("a record has the marks in the order of the stages, and the first sweep ends the collision stage") {
  TickProbe probe({1000, 0, 0});
  TickTiming timing;
  timing.scheduled_ns = timing.woke_ns = MonotonicClock::now_ns();
  probe.begin(timing);
  probe.read_done(MonotonicClock::now_ns());
  const StageObserver stages = probe.stages();
  stages(TickStage::kAdopt);
  stages(TickStage::kCouple);
  const std::int64_t first_sweep_ns = MonotonicClock::now_ns();
  probe.sweep_begins(first_sweep_ns);
  probe.sweep_begins(first_sweep_ns + 1000);
  stages(TickStage::kStep);
  const std::int64_t computed_ns = MonotonicClock::now_ns();
  probe.times().members = 7;
  probe.end(computed_ns, computed_ns + 10);
  const auto records = drained(probe);
  REQUIRE(records.size() == 1);
  const TickTimes& t = records[0].times;
  CHECK(records[0].kind == kLoopTimes);
  CHECK(t.members == 7);
  CHECK(t.collided_ns == first_sweep_ns);
  CHECK(t.woke_ns <= t.read_ns);
  CHECK(t.read_ns <= t.adopted_ns);
  CHECK(t.adopted_ns <= t.coupled_ns);
  CHECK(t.coupled_ns <= t.collided_ns);
  CHECK(t.collided_ns <= t.stepped_ns);
  CHECK(t.stepped_ns <= t.computed_ns);
  CHECK(t.wrote_ns == computed_ns + 10);
  CHECK(probe.thread_id() > 0);
}

TEST_CASE("a tick of the bare timer is its wake-up and nothing else") {
  TickProbe probe({1, 1, 0});
  TickTiming timing;
  timing.scheduled_ns = 1000;
  timing.woke_ns = 4000;
  timing.deadline = 1;
  probe.bare(timing);
  const auto records = drained(probe);
  REQUIRE(records.size() == 1);
  CHECK(records[0].kind == kBareTimes);
  CHECK(records[0].times.woke_ns == 4000);
  CHECK(records[0].times.wrote_ns == 4000);
}

TEST_CASE("a tick reports its stages in their order, once each, and computes the same as without an observer") {
  test::haptic_loop_bench::Bench watched, alone;
  std::vector<TickStage> seen;
  watched.in.stages = {
      [](void* list, TickStage stage) noexcept { static_cast<std::vector<TickStage>*>(list)->push_back(stage); },
      &seen};
  watched.tick(kArm);
  alone.tick(kArm);
  CHECK(seen == std::vector<TickStage>{TickStage::kAdopt, TickStage::kCouple, TickStage::kStep});
  watched.run(100);
  alone.run(100);
  CHECK(seen.size() == 3 * 101);
  CHECK(watched.loop.state_hash() == alone.loop.state_hash());
}
