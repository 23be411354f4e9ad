// A long step is taken in as many macro steps as its fastest body needs, a tick in one.
#include "rt/physics/macro_steps.h"

#include <catch2/catch.hpp>

#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::PhysicsBench;

namespace {

PhysicsBench bench_of(double step_s, std::uint32_t sub_steps) {
  PhysicsBench bench;
  bench.settings.dt = step_s;
  bench.settings.sub_steps = sub_steps;
  return bench;
}

}  // namespace

TEST_CASE("At rest a step has one macro step, and so has a tick, however fast") {
  auto slow = bench_of(0.01, 40), tick = bench_of(0.001, 4);
  slow.add_box(0, {0.05, 0.05, 0.05}, 1, 0.5, {}, {{0.1, 0, 0}, {}});
  tick.add_box(0, {0.05, 0.05, 0.05}, 1, 0.5, {}, {{30, 0, 0}, {}});
  CHECK(macro_steps_of(slow.world, slow.settings) == 1);
  CHECK(macro_steps_of(tick.world, tick.settings) == 1);
}

TEST_CASE(
    "A step has the fewest macro steps that divide it and let no body move further than a quarter of its half "
    "thickness") {
  const double half = 0.02, allowed = 0.25 * half;
  const std::uint32_t most = 10;  // one a millisecond
  for (std::uint32_t sub_steps = 1; sub_steps <= 60; ++sub_steps)
    for (const double moved : {0.9, 1.5, 2.5, 4.5, 6.5, 9.9, 300.0}) {
      std::uint32_t fewest = 0, largest = 1;
      for (std::uint32_t macro_steps = 1; macro_steps <= most; ++macro_steps) {
        if (sub_steps % macro_steps != 0) continue;
        largest = macro_steps;
        if (fewest == 0 && moved <= macro_steps) fewest = macro_steps;
      }
      auto bench = bench_of(0.01, sub_steps);
      bench.add_box(0, {0.1, half, 0.1}, 1, 0.5, {}, {{moved * allowed / 0.01, 0, 0}, {}});
      INFO(moved << " times the motion allowed, " << sub_steps << " sub-steps");
      const std::uint32_t macro_steps = macro_steps_of(bench.world, bench.settings);
      CHECK(macro_steps == (fewest != 0 ? fewest : largest));
      const auto macro_step = settings_of_macro_step(bench.settings, macro_steps);
      CHECK(macro_step.dt / macro_step.sub_steps == Approx(bench.h()).epsilon(1e-12));
    }
}

TEST_CASE("A ball that rolls goes on by sqrt(2 slop r) in a macro step, one that flies by a quarter of its radius") {
  const double radius = 0.02, along = std::sqrt(2 * 1e-5 * radius);
  auto bench = bench_of(0.01, 40);
  bench.add_ground(1, 0.5);
  bench.add_sphere(0, radius, 0.2, 0.5, {0, 0, radius});
  bench.step();
  bench.velocity(0).linear.x = 3.5 * along / 0.01;
  CHECK(macro_steps_of(bench.world, bench.settings) == 4);
  auto flying = bench_of(0.01, 40);
  flying.add_sphere(0, radius, 0.2, 0.5, {}, {3.5 * along / 0.01, 0, 0});
  CHECK(macro_steps_of(flying.world, flying.settings) == 1);
  const std::uint8_t left_out[] = {1};
  CHECK(macro_steps_of(bench.world, bench.settings, left_out) == 1);
}

TEST_CASE("A box that slides over a fixed ball goes on by sqrt(2 slop r of the ball) in a macro step") {
  const double radius = 0.02, along = std::sqrt(2 * 1e-5 * radius);
  auto bench = bench_of(0.01, 40);
  bench.world.insert(make_fixed_body(1, Shape::sphere(radius), 0.5, {}));
  bench.add_box(0, {0.1, 0.1, 0.1}, 0.2, 0.5, {{0, 0, radius + 0.1}, {}});
  bench.step();
  bench.velocity(0) = {{3.5 * along / 0.01, 0, 0}, {}};
  CHECK(macro_steps_of(bench.world, bench.settings) == 4);
}
