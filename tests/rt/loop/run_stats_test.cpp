#include "rt/loop/run_stats.h"

#include <bit>
#include <catch2/catch.hpp>

using namespace tactus;
using namespace tactus::loop;

namespace {

constexpr std::uint32_t kRatio = 10;

// A run, tick by tick.
struct Run {
  RunStats stats;
  TickOutput out;
  void add(std::uint32_t sub_steps = 4, std::uint32_t component = 0, std::uint32_t cycle_ticks = 0) {
    stats.add(out, sub_steps, component, cycle_ticks, kRatio);
    ++out.tick;
  }
  std::uint64_t ticks_with(StatusBit bit) const {
    return stats.status_ticks[static_cast<std::size_t>(std::countr_zero(static_cast<std::uint32_t>(bit)))];
  }
};

}  // namespace

TEST_CASE("ticks are counted by what they were: in contact, armed, with each status bit") {
  Run run;
  for (std::uint32_t t = 0; t < 30; ++t) {
    run.out.status = 0;
    if (t < 10) run.out.status |= kNotArmed;
    if (t >= 25) run.out.status |= kProxyContact | kWorldLate;
    if (t == 7) run.out.status |= kFrameMissing;
    run.add(t < 5 ? 2 : 4);
  }
  CHECK(run.stats.ticks == 30);
  CHECK(run.stats.armed_ticks == 20);
  CHECK(run.stats.contact_ticks == 5);
  CHECK(run.ticks_with(kFrameMissing) == 1);
  CHECK(run.ticks_with(kWorldLate) == 5);
  CHECK(run.ticks_with(kNotArmed) == 10);
  CHECK(run.ticks_with(kProxyContact) == 5);
  std::uint64_t all = 0;
  for (const std::uint64_t ticks : run.stats.status_ticks) all += ticks;
  CHECK(all == 1 + 5 + 10 + 5);
  CHECK(run.stats.sub_steps_sum == 5 * 2 + 25 * 4);
}

TEST_CASE("the largest counts of a run are kept, each for itself") {
  Run run;
  run.out.members = 5;
  run.out.border = 9;
  run.out.contacts = 1;
  run.out.points = 4;
  run.out.pairs = 7;
  run.out.capacity_bits = 2;
  run.out.dropped = 3;
  run.out.deepest_m = 1e-3;
  run.out.deepest_share = 0.2;
  run.add(4, 100);
  run.out.members = 6;
  run.out.border = 2;
  run.out.contacts = 2;
  run.out.points = 3;
  run.out.pairs = 8;
  run.out.capacity_bits = 8;
  run.out.dropped = 4;
  run.out.deepest_m = 1e-4;
  run.out.deepest_share = 0.1;
  run.add(4, 50);
  CHECK(run.stats.members_max == 6);
  CHECK(run.stats.border_max == 9);
  CHECK(run.stats.contacts_max == 2);
  CHECK(run.stats.points_max == 4);
  CHECK(run.stats.pairs_max == 8);
  CHECK(run.stats.component_max == 100);
  CHECK(run.stats.capacity_bits == 10);
  CHECK(run.stats.dropped == 7);
  CHECK(run.stats.deepest_m == 1e-3);
  CHECK(run.stats.deepest_share == 0.2);
}

TEST_CASE("a cycle is late when it took more ticks than the ratio") {
  Run run;
  for (const std::uint32_t ticks : {0u, 10u, 0u, 11u, 10u, 35u, 0u}) run.add(4, 0, ticks);
  CHECK(run.stats.cycles == 4);
  CHECK(run.stats.late_cycles == 2);
  CHECK(run.stats.cycle_ticks_max == 35);
}

TEST_CASE("forces: largest, sum, and the largest step between two ticks, from the second on") {
  Run run;
  run.out.command.wrench = {{3, 0, 4}, {0, 1, 0}};
  run.out.device_energy_J = 1;
  run.out.damped_energy_J = 2;
  run.out.border_work_J = 3;
  run.add();
  CHECK(run.stats.force_step_max_N == 0);  // nothing is known of before
  run.out.command.wrench = {{3, 0, 0}, {0, 0, 2}};
  run.add();
  run.out.command.wrench = {};
  run.out.device_energy_J = -1;
  run.out.damped_energy_J = 4;
  run.out.border_work_J = -5;
  run.out.corrected_J = -0.5;
  run.out.border_tank_J = 0.01;
  run.add();
  CHECK(run.stats.force_max_N == 5);
  CHECK(run.stats.torque_max_Nm == 2);
  CHECK(run.stats.force_sum_N == 8);
  CHECK(run.stats.force_step_max_N == 4);
  // Energies are sums already: the last word counts.
  CHECK(run.stats.device_energy_J == -1);
  CHECK(run.stats.damped_energy_J == 4);
  CHECK(run.stats.border_work_J == -5);
  CHECK(run.stats.corrected_J == -0.5);
  CHECK(run.stats.border_tank_J == 0.01);
}

TEST_CASE("faults are listed where they latch and where a re-arm takes them back") {
  Run run;
  const auto ticks = [&](Fault fault, int count) {
    run.out.fault = fault;
    for (int i = 0; i < count; ++i) run.add();
  };
  ticks(Fault::kNone, 5);
  ticks(Fault::kLinkLost, 3);
  ticks(Fault::kNone, 2);
  ticks(Fault::kDeviceBrake, 4);
  ticks(Fault::kInputJump, 1);  // re-armed and latched again within a tick
  REQUIRE(run.stats.faults.size() == 4);
  const auto check = [&](std::uint32_t i, std::uint64_t tick, Fault fault, std::uint32_t cleared) {
    CAPTURE(i);
    CHECK(run.stats.faults[i].tick == tick);
    CHECK(run.stats.faults[i].fault == fault);
    CHECK(run.stats.faults[i].cleared == cleared);
  };
  check(0, 5, Fault::kLinkLost, 0);
  check(1, 8, Fault::kLinkLost, 1);
  check(2, 10, Fault::kDeviceBrake, 0);
  check(3, 14, Fault::kInputJump, 0);
  CHECK(run.stats.fault_count == 3);
}

TEST_CASE("faults beyond the list are counted all the same") {
  Run run;
  for (int i = 0; i < 40; ++i) {
    run.out.fault = i % 2 == 0 ? Fault::kLinkLost : Fault::kNone;
    run.add();
  }
  CHECK(run.stats.faults.size() == 16);
  CHECK(run.stats.fault_count == 20);
  CHECK(run.stats.faults[14].tick == 14);
  CHECK(run.stats.faults[15].tick == 39);  // the newest
  CHECK(run.stats.fault_events_dropped == 24);
}

TEST_CASE("an overrun's cause: late wake-up, own work, or the machine") {
  constexpr double kPeriod = 1e6;
  struct {
    double wake_ns, used_ns, predicted_ns;
    OverrunCause cause;
  } const table[] = {
      {0, 5e5, 5e5, OverrunCause::kInterrupted},    // awake in time, little used: somebody else had the core
      {4e5, 5e5, 5e5, OverrunCause::kInterrupted},  // would have done still
      {4e5, 6.1e5, 5e5, OverrunCause::kLateWake},   // the wake-up took what the work needed
      {0, 1.1e6, 6e5, OverrunCause::kOwnWork},      // more than any period has, and the counts say so
      {0, 1.1e6, 5e5, OverrunCause::kInterrupted},  // the counts do not explain it
      {5.1e5, 1.1e6, 6e5, OverrunCause::kOwnWork},  // nor would it have done had it woken in time
      {5.1e5, 1e5, 1e5, OverrunCause::kLateWake},   // the wake-up alone took half
      {4e5, 9e6, 1e5, OverrunCause::kInterrupted},  // late, but what it needed would still have fitted
      {5e5, 5e5, 5e5, OverrunCause::kInterrupted},  // both bounds are still inside
  };
  for (const auto& row : table) {
    CAPTURE(row.wake_ns, row.used_ns, row.predicted_ns);
    CHECK(classify_overrun(row.wake_ns, row.used_ns, row.predicted_ns, kPeriod) == row.cause);
  }
}

TEST_CASE("cost predictions are counted against what the ticks took") {
  CostPredictionStats cost_prediction;
  for (int i = 0; i < 90; ++i) cost_prediction.add(100'000, 80'000);
  for (int i = 0; i < 10; ++i) cost_prediction.add(200'000, 300'000);
  CHECK(cost_prediction.above == 10);
  // The histogram's buckets are a sixty-fourth wide at most.
  CHECK(static_cast<double>(cost_prediction.predicted_ns.percentile_ns(50)) == Approx(100'000).epsilon(1.0 / 64));
  CHECK(static_cast<double>(cost_prediction.predicted_ns.percentile_ns(99)) == Approx(200'000).epsilon(1.0 / 64));
  CHECK(static_cast<double>(cost_prediction.measured_permille.percentile_ns(50)) == Approx(800).epsilon(1.0 / 64));
  CHECK(static_cast<double>(cost_prediction.measured_permille.percentile_ns(99)) == Approx(1500).epsilon(1.0 / 64));
  cost_prediction.add(0, 10);  // a model that predicts nothing is no division by zero
  CHECK(cost_prediction.above == 11);
}
