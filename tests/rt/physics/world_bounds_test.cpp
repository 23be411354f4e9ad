// The bounds that begin_step gives the pair finder.
#include <algorithm>
#include <catch2/catch.hpp>

#include "rt/physics/world.h"
#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::PhysicsBench;
using tactus::test::Random;

TEST_CASE("Bodies that may touch in a step have bounds that overlap, whichever of them moves or falls", "[slow]") {
  Random random(4);
  for (int n = 0; n < 2000; ++n) {
    PhysicsBench bench;
    bench.settings.dt = n % 2 == 0 ? 1e-3 : 1e-2;
    bench.settings.sub_steps = n % 3 == 0 ? 1 : 5;
    const double half = random(0.005, 0.05), speed = random(0, 1), turn = random(0, 3);
    bench.add_box(1, {half, half, half}, 0.2, 0.5, {{0, 0, 1}, {}}, {{0, 0, -speed}, {turn, 0, 0}});
    bench.body(1).gravity_scale = random(0, 3);
    const double fall = fall_in_step(bench.settings);
    // What waits below: held, floating, coming up, or a fixed body.
    const double coming = n % 5 == 2 ? speed * bench.settings.dt : 0;
    const double closing = speed * bench.settings.dt + coming + bench.body(1).gravity_scale * fall +
                           turn * bench.settings.dt * std::sqrt(3.0) * half;
    const double gap = 0.999 * std::max(closing, bench.settings.min_margin);
    const Vec3d below{0, 0, 1 - 2 * half - gap};
    if (n % 5 < 3) bench.add_box(2, {half, half, half}, 0.2, 0.5, {below, {}});
    if (n % 5 == 0) bench.world.set_frozen(SlotIndex{1}, true);
    if (n % 5 == 1) bench.body(2).gravity_scale = 0;
    if (n % 5 == 2) bench.velocity(2).linear.z = speed;
    if (n % 5 == 3) bench.world.insert(make_fixed_body(2, Shape::box({half, half, half}), 0.5, {below, {}}));
    if (n % 5 == 4) bench.world.insert(make_fixed_body(2, Shape::plane(), 0.5, {{0, 0, below.z + half}, {}}));
    bench.step();
    REQUIRE(bench.report.pairs == 1);
    if (n % 5 != 0) continue;
    // And not much further than need be: a millimetre more, and they are no pair.
    bench.body(1).motion = {{{0, 0, 1 + 1.2e-3 + fall}, {}}, {{0, 0, -speed}, {turn, 0, 0}}};
    bench.step();
    REQUIRE(bench.report.pairs == 0);
  }
}

TEST_CASE("What a body with the fewer sub-steps falls on is found, though the others take more") {
  PhysicsBench bench;
  bench.settings.dt = 1e-2;
  bench.settings.sub_steps = 1;
  const double gap = 0.999 * fall_in_step(bench.settings);
  bench.add_ground(9, 0.5);
  bench.add_box(1, {0.05, 0.05, 0.05}, 0.2, 0.5, {{0, 0, 0.05 + gap + 0.999 * carry_over_margin(bench.settings)}, {}});
  bench.world.begin_step(bench.settings);
  bench.settings.sub_steps = 5;
  CHECK(bench.world.finish_step(bench.settings).pairs == 1);
}

TEST_CASE("The bounds of a step hold what a body moves in it, and no more than the largest margin, however fast") {
  PhysicsBench bench;
  bench.add_box(1, {0.05, 0.02, 0.01}, 0.2, 0.5, {{0, 0, 1}, quat_from_rotation_vector(Vec3d{1, 2, 3})},
                {{1, -2, 0.5}, {10, 5, -20}});
  bench.world.begin_step(bench.settings);
  const Aabb before = bench.world.bounds()[0];
  static_cast<void>(bench.world.finish_step(bench.settings));
  const Aabb after = bounds_of(bench.body(1).shape, bench.body(1).motion.pose, 0.0);
  CHECK(before.holds(after));
  bench.velocity(1).linear = {1e4, 0, 0};
  bench.world.begin_step(bench.settings);
  const Aabb tight = bounds_of(bench.body(1).shape, bench.body(1).motion.pose, 0.0);
  CHECK(bench.world.bounds()[0].upper.x - tight.upper.x ==
        Approx(bench.settings.max_margin + 0.5 * carry_over_margin(bench.settings)));
}
