#include "rt/loop/calibration.h"

#include <algorithm>
#include <array>

#include "rt/base/clock.h"
#include "rt/physics/world.h"

namespace tactus::loop {
namespace {

constexpr std::uint32_t kColumns = 16, kHeight = 4;  // 64 boxes in stacks: a sub-world of the usual size
constexpr std::uint32_t kWarmTicks = 40, kMeasuredTicks = 120;

physics::World<double> make_stacks() {
  physics::Capacities capacities;
  capacities.bodies = kColumns * kHeight;
  physics::World<double> world(capacities);
  const auto box = physics::Shape<double>::box({0.05, 0.05, 0.05});
  BodyId id = 0;
  TACTUS_CHECK(world.insert(physics::make_fixed_body<double>(id++, physics::Shape<double>::plane(), 0.5, {})), 0, 0);
  for (std::uint32_t column = 0; column < kColumns; ++column) {
    for (std::uint32_t level = 0; level < kHeight; ++level) {
      const Posed pose{{0.2 * (column % 4), 0.2 * (column / 4), 0.05 + 0.1 * level}, {}};
      TACTUS_CHECK(world.insert(physics::make_dynamic_body<double>(id++, box, 1.0, 0.5, pose)), id, 0);
    }
  }
  return world;
}

physics::StepReport<double> step(physics::World<double>& world, std::uint32_t sub_steps) {
  physics::StepSettings<double> settings;
  settings.gravity = {0, 0, -9.81};
  settings.sub_steps = sub_steps;
  settings.recycle_tolerance_m = 0;  // these stacks rest; where everything moves every contact is found anew
  world.begin_step(settings);
  (void)physics::find_pairs_brute_force(world.bounds(), world.dynamic_pairs());
  return world.finish_step(settings);
}

struct Measured {
  double p50{0}, p90{0}, p99{0}, predicted{0};
};

Measured measure(physics::World<double>& world, const CostModel& table, std::uint32_t sub_steps) {
  MonotonicClock clock;
  std::array<double, kMeasuredTicks> times{};
  Measured result;
  for (std::uint32_t tick = 0; tick < kWarmTicks + kMeasuredTicks; ++tick) {
    const auto begin = clock.now_ns();
    const auto report = step(world, sub_steps);
    if (tick >= kWarmTicks) times[tick - kWarmTicks] = static_cast<double>(clock.now_ns() - begin);
    const WorkCounts counts{kColumns * kHeight, report.pairs, report.contacts, report.points, 0, 0, false};
    result.predicted = predict_ns(table, counts, sub_steps);
  }
  std::sort(times.begin(), times.end());
  result.p50 = times[kMeasuredTicks / 2];
  result.p90 = times[kMeasuredTicks * 9 / 10];
  result.p99 = times[kMeasuredTicks * 99 / 100];
  return result;
}

}  // namespace

void work_beside(const std::atomic<bool>& stop) {
  physics::World<double> world = make_stacks();
  while (!stop.load(std::memory_order_relaxed)) (void)step(world, 4);
}

Calibration calibrate(const CostModel& table, double safety) {
  physics::World<double> world = make_stacks();
  const Measured few = measure(world, table, 1), many = measure(world, table, 8);
  Calibration result;
  const double worst = std::max(few.p90 / few.predicted, many.p90 / many.predicted);
  result.scale = std::clamp(safety * worst, 0.125, 64.0);
  result.spread = std::max(few.p99 / few.p50, many.p99 / many.p50);
  CostModel& c = result.cost = table;
  for (double* value : {&c.fixed, &c.per_body, &c.per_pair, &c.per_contact, &c.per_point_sub_step, &c.per_body_sub_step,
                        &c.per_border_sub_step, &c.synchronisation, &c.per_join})
    *value *= result.scale;
  return result;
}

}  // namespace tactus::loop
