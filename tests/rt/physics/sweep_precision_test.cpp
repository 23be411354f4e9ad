// Contacts solved in single precision: a value that a step does not change keeps every bit, and a change is exact to
// single precision, at any distance from the world's origin.
#include <catch2/catch.hpp>

#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::PhysicsBench;

namespace {

constexpr double kHalf = 0.05;

struct MixedBench : PhysicsBench {
  MixedBench() { world = World({}, {}, {}, SweepPrecision::kSingle); }
};

double fastest(const PhysicsBench& bench) {
  double speed = 0;
  for (const Body& body : bench.world.bodies()) speed = std::max(speed, norm(body.motion.velocity.linear));
  return speed;
}

}  // namespace

TEST_CASE("Sweeps in single precision leave a free body's velocity as it is, to the last bit") {
  MixedBench bench;
  bench.settings.gravity = {};
  const Twistd thrown{{1.0 / 3, -2.0 / 7, 0.1}, {0.3, 0.7, -1.0 / 9}};
  bench.add_box(1, {kHalf, kHalf, kHalf}, 1, 0.5, {}, thrown);
  bench.run(1000);
  CHECK(bench.velocity(1).linear == thrown.linear);
  CHECK(bench.velocity(1).angular == thrown.angular);
  // The motion of a step is exact to single precision; at worst all 1000 steps round to the same side.
  CHECK(norm(bench.position(1) - 1.0 * thrown.linear) < 6e-8 * norm(thrown.linear) * 4);
}

TEST_CASE("Sweeps in single precision hold a stack as deep as the stiffness says, near the origin and 1 km off") {
  for (const double far : {0.0, 1000.0}) {
    MixedBench bench;
    bench.add_ground(1000, 0.5);
    bench.add_stack(0, 10, kHalf, 1, 0.5);
    for (auto& body : bench.world.bodies()) body.motion.pose.position.x += far;
    bench.run_seconds(8);
    INFO("at " << far << " m");
    CHECK(fastest(bench) < 1e-6);
    const double mass = test::cube_face_mass(1, kHalf, true);  // of the lowest, under the weight of ten
    CHECK(kHalf - bench.position(0).z == Approx(bench.overlap_under(10 * test::kGravity, mass)).epsilon(0.05));
  }
}

TEST_CASE("Sweeps in single precision give the same bits twice, and keep momentum in a collision to their precision") {
  const auto collide = [] {
    MixedBench bench;
    bench.settings.gravity = {};
    bench.add_box(1, {kHalf, kHalf, kHalf}, 1, 0.5, {}, {{1, 0, 0}, {}});
    bench.add_box(2, {kHalf, kHalf, kHalf}, 3, 0.5, {{0.15, 0.02, 0.01}, {}}, {{-1, 0, 0}, {}});
    const Vec3d before = bench.world.momentum().force;
    bench.run(300);
    CHECK(norm(bench.world.momentum().force - before) < 1e-5);
    CHECK(bench.velocity(1).linear.x < 0);  // they met
    return bench.world.state_hash();
  };
  CHECK(collide() == collide());
}
