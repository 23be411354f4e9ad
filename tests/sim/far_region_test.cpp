// Fewer sub-steps far from every sub-world: what the coarse region conserves, and that other bodies do not change.
#include "tests/sim/global_world_bench.h"

namespace {

using namespace tactus;
using namespace tactus::sim;
using physics::Shape;
using Bench = test::GlobalWorldBench;
using test::kGlobalStep_s;

constexpr double kHalf_m = 0.05, kMass_kg = 0.2, kGravity = 9.81;
constexpr BodyId kGround = 1;

// The proxy floats above x = 0. Near sub-steps 40 in a step of 10 ms, far ones 10.
Scene with_stacks(std::initializer_list<double> places, unsigned far_sub_steps_per_tick = 1) {
  Scene scene;
  scene.effects = {true, true, false, false};
  scene.solver.global_sub_steps_per_tick = 4;
  scene.solver.far_sub_steps_per_tick = far_sub_steps_per_tick;
  scene.proxy = 0;
  scene.bodies.push_back(physics::make_dynamic_body(0, Shape::sphere(0.02), 0.2, 0.5, {{0, 0, 0.33}, {}}));
  scene.bodies[0].gravity_scale = 0;
  scene.bodies.push_back(physics::make_fixed_body(kGround, Shape::plane(), 0.5, {}));
  for (const double x : places)
    for (int k = 0; k < 3; ++k)
      scene.bodies.push_back(physics::make_dynamic_body(static_cast<BodyId>(scene.bodies.size()),
                                                        Shape::box({kHalf_m, kHalf_m, kHalf_m}), kMass_kg, 0.5,
                                                        {{x, 0, kHalf_m * (2 * k + 1)}, {}}));
  return scene;
}

}  // namespace

TEST_CASE("A far stack presses as hard and sinks as deep as one near the proxy: the stiffness is the same") {
  Bench bench(with_stacks({0, 3}));
  bench.run(200);
  CHECK(bench.snapshot->members.size() == 4);
  for (const BodyId lowest : {2u, 5u})
    CHECK(bench.force_between_N(lowest, kGround) == Approx(3 * kMass_kg * kGravity).epsilon(1e-3));
  const auto sunk_m = [&](BodyId id) { return kHalf_m * (2 * ((id - 2) % 3) + 1) - bench.motion(id).pose.position.z; };
  CHECK(sunk_m(2) > 1e-5);
  for (BodyId k = 0; k < 3; ++k) CHECK(sunk_m(2 + k) == Approx(sunk_m(5 + k)).epsilon(0.02));
}

TEST_CASE("Bodies near the proxy have the same bits however the far region is stepped") {
  Bench alone(with_stacks({0})), beside(with_stacks({0, 3})), as_often(with_stacks({0, 3}, 4));
  for (int i = 0; i < 50; ++i) {
    alone.run(1);
    beside.run(1);
    as_often.run(1);
    for (BodyId id = 2; id < 5; ++id) REQUIRE(alone.motion(id) == beside.motion(id));
  }
  CHECK_FALSE(beside.motion(5) == as_often.motion(5));
}

TEST_CASE("A far body falls by the far region's sub-steps, one near the proxy and its neighbour by their own") {
  Scene scene = with_stacks({0, 3});
  scene.bodies[4].motion.pose.position = {0.09, 0, 0.33};    // in reach of the proxy's next two cycles
  scene.bodies[3].motion.pose.position = {0.1905, 0, 0.33};  // not, but half a millimetre beside the other
  scene.bodies[7].motion.pose.position = {3, 0, 2};
  Bench bench(scene);
  bench.run(1);
  const auto fallen_m = [](double sub_steps) {
    const double h = kGlobalStep_s / sub_steps;
    return kGravity * h * h * sub_steps * (sub_steps + 1) / 2;
  };
  CHECK(2 - bench.motion(7).pose.position.z == Approx(fallen_m(10)).epsilon(1e-6));
  for (const BodyId id : {3u, 4u}) CHECK(0.33 - bench.motion(id).pose.position.z == Approx(fallen_m(40)).epsilon(1e-6));
}

TEST_CASE("A stack that changes regions does not jolt") {
  Bench bench(with_stacks({0, 3}));
  bench.run(200);
  const auto before = bench.motion(7);
  bench.impose_proxy({3, 0, 0.33});
  for (int i = 0; i < 50; ++i) {
    bench.run(1);
    for (BodyId id = 2; id < 8; ++id) REQUIRE(std::abs(bench.motion(id).velocity.linear.z) < 1e-3);
  }
  CHECK(std::abs(bench.motion(7).pose.position.z - before.pose.position.z) < 5e-6);
  CHECK(bench.force_between_N(2, kGround) == Approx(3 * kMass_kg * kGravity).epsilon(1e-3));
  CHECK(bench.force_between_N(5, kGround) == Approx(3 * kMass_kg * kGravity).epsilon(1e-3));
}
