#include "rt/physics/integrate.h"

#include <catch2/catch.hpp>

#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::kGravity;
using tactus::test::kPi;
using tactus::test::PhysicsBench;

namespace {

// A box whose principal inertias are as given (kg m^2), far from everything.
Body free_body(const Vec3d& inertia, const Vec3d& w) {
  Body body = make_dynamic_body(1, Shape::sphere(0.01), 1.0, 0.0, {});
  body.inertia = inertia;
  body.motion.velocity.angular = w;
  return body;
}

Vec3d spin_in_body(const Body& body) { return rotate_inverse(body.motion.pose.rotation, body.motion.velocity.angular); }

// Complete elliptic integral of the first kind by the arithmetic-geometric mean.
double elliptic_k(double modulus_squared) {
  double a = 1, g = std::sqrt(1 - modulus_squared);
  for (int i = 0; i < 40; ++i) {
    const double mean = 0.5 * (a + g);
    g = std::sqrt(a * g);
    a = mean;
  }
  return kPi / (2 * a);
}

}  // namespace

TEST_CASE("A thrown body follows the semi-implicit recurrence, g t h / 2 below the parabola") {
  for (const unsigned sub_steps : {1u, 4u, 10u}) {
    PhysicsBench bench;
    bench.settings.sub_steps = sub_steps;
    const Vec3d x0{1, 2, 3}, v0{0.5, -1, 4};
    bench.add_sphere(1, 0.01, 0.2, 0.5, x0, v0);
    bench.run(500);
    const double t = 0.5;
    const Vec3d expected = bench.thrown(x0, v0, 500ull * sub_steps);
    CHECK(norm(bench.position(1) - expected) < 1e-12);
    const double parabola = x0.z + v0.z * t - kGravity * t * t / 2;
    CHECK(parabola - bench.position(1).z == Approx(kGravity * t * bench.h() / 2).epsilon(1e-9));
    CHECK(bench.velocity(1).linear.z == Approx(v0.z - kGravity * t).epsilon(1e-12));
  }
}

TEST_CASE("A body that nothing acts on keeps its velocity to the last bit") {
  PhysicsBench bench;
  bench.settings.gravity = {};
  const Vec3d v0{0.1, -0.2, 0.3}, w0{3, 2, 1};
  bench.add_sphere(1, 0.05, 0.2, 0.5, {}, v0);
  bench.velocity(1).angular = w0;
  bench.run(1000);
  CHECK(bench.velocity(1).linear == v0);
  CHECK(bench.velocity(1).angular == w0);
  CHECK(norm(bench.position(1) - v0) < 1e-12);  // 1 s
  const Quatd expected = quat_from_rotation_vector(w0);
  CHECK(norm(small_rotation_vector(bench.body(1).motion.pose.rotation * conjugate(expected))) < 1e-10);
}

TEST_CASE("The exponential map is the same where its two forms meet") {
  for (const double angle : {0.0, 1e-9, 0.05, 0.0999999, 0.1000001, 0.5}) {
    const Vec3d w = normalized_or(Vec3d{1, -2, 0.5}, {}) * angle;
    const Quatd turned = rotate_steadily(w, 1.0).change;
    CHECK(turned.w == Approx(std::cos(angle / 2)).epsilon(1e-15));
    CHECK(norm(turned.vec()) == Approx(std::sin(angle / 2)).epsilon(1e-14).margin(1e-18));
    CHECK(rotate_steadily(w, 1.0).angular_velocity == w);
  }
}

TEST_CASE("A body that spins about its middle axis tumbles with the period of Jacobi's elliptic functions") {
  PhysicsBench bench;
  bench.settings.gravity = {};
  const Vec3d inertia{1e-3, 2e-3, 3e-3};
  bench.world.insert(free_body(inertia, {0.02, 50, 0.03}));
  const double energy = bench.world.kinetic_energy();
  const Vec3d momentum = bench.world.momentum().torque;
  double worst_energy = 0, worst_momentum = 0, last_crossing = -1;
  std::vector<double> intervals;
  double before = spin_in_body(bench.body(1)).y;
  for (int k = 1; k <= 60000; ++k) {
    bench.step();
    worst_energy = std::max(worst_energy, std::abs(bench.world.kinetic_energy() / energy - 1));
    worst_momentum = std::max(worst_momentum, norm(bench.world.momentum().torque - momentum) / norm(momentum));
    const double now = spin_in_body(bench.body(1)).y;
    if ((before < 0) != (now < 0)) {
      const double crossing = (k - 1 + before / (before - now)) * bench.settings.dt;
      if (last_crossing >= 0) intervals.push_back(crossing - last_crossing);
      last_crossing = crossing;
    }
    before = now;
  }
  CHECK(worst_energy < 1e-6);
  CHECK(worst_momentum < 1e-3);
  // Middle axis: w_y is an elliptic sine with zeros 2 K apart.
  const double l2 = norm_squared(momentum), e2 = 2 * energy;
  REQUIRE(l2 > e2 * inertia.y);  // it tumbles about the axis of the largest inertia
  const double rate = std::sqrt((inertia.z - inertia.y) * (l2 - e2 * inertia.x) / (inertia.x * inertia.y * inertia.z));
  const double modulus_squared =
      (inertia.y - inertia.x) * (e2 * inertia.z - l2) / ((inertia.z - inertia.y) * (l2 - e2 * inertia.x));
  REQUIRE(intervals.size() > 50);
  double mean = 0;
  for (const double interval : intervals) mean += interval / static_cast<double>(intervals.size());
  CHECK(mean == Approx(2 * elliptic_k(modulus_squared) / rate).epsilon(0.01));
}

TEST_CASE("A thin rod that spins fast gains no energy") {
  PhysicsBench bench;
  bench.settings.gravity = {};
  bench.world.insert(free_body({1e-3, 1e-3, 2e-5}, {10, 0, 200}));
  const double energy = bench.world.kinetic_energy();
  for (int k = 0; k < 10000; ++k) {
    bench.step();
    REQUIRE(std::abs(bench.world.kinetic_energy() / energy - 1) < 1e-3);
  }
}

TEST_CASE("A body that spins by more than half a radian in a sub-step keeps its energy, whatever its inertia") {
  for (const double spin : {2.5e3, 3e4, 1e6}) {  // rad/s, in sub-steps of 0.25 ms
    PhysicsBench bench;
    bench.settings.gravity = {};
    bench.world.insert(free_body({1e-6, 2e-6, 3e-4}, {spin, 0.7 * spin, -0.3 * spin}));
    const double before = bench.world.kinetic_energy();
    bench.run(1000);
    CHECK(bench.world.kinetic_energy() == Approx(before).epsilon(1e-9));
  }
}

TEST_CASE("Without the gyroscopic effect the angular velocity stays as it is") {
  PhysicsBench bench;
  bench.settings.gravity = {};
  bench.settings.gyroscopic = false;
  const Vec3d w0{1, 20, 2};
  bench.world.insert(free_body({1e-3, 2e-3, 3e-3}, w0));
  bench.run(500);
  CHECK(bench.velocity(1).angular == w0);
  bench.settings.gyroscopic = true;
  bench.run(1);
  CHECK(bench.velocity(1).angular != w0);
}

TEST_CASE("A wrench acts for one step: momentum grows by wrench times time, then no more") {
  PhysicsBench bench;
  bench.settings.gravity = {};
  bench.world.insert(free_body({1e-3, 1e-3, 1e-3}, {}));
  bench.add_sphere(2, 0.01, 0.5, 0.5, {5, 0, 0});
  bench.world.apply_wrench(SlotIndex{0}, {{1, 2, 3}, {0.1, 0, 0}});
  bench.world.apply_wrench(SlotIndex{0}, {{1, 0, 0}, {0, 0.2, 0}});  // they add up
  for (int k = 0; k < 3; ++k) {
    bench.step();
    CHECK(norm(bench.velocity(1).linear - Vec3d{2e-3, 2e-3, 3e-3}) < 1e-15);
    CHECK(norm(bench.velocity(1).angular - Vec3d{0.1, 0.2, 0}) < 1e-12);
    CHECK(bench.velocity(2) == Twistd{});
  }
}

TEST_CASE("A body with gravity scale 0 floats, and no gravity moves nothing") {
  PhysicsBench bench;
  bench.add_sphere(1, 0.01, 0.2, 0.5, {0, 0, 1});
  bench.add_sphere(2, 0.01, 0.2, 0.5, {1, 0, 1});
  bench.body(1).gravity_scale = 0;
  bench.run(10);
  CHECK(bench.position(1) == Vec3d{0, 0, 1});
  CHECK(bench.position(2).z < 1);
  PhysicsBench still;
  still.settings.gravity = {};
  still.add_sphere(1, 0.01, 0.2, 0.5, {0, 0, 1});
  still.run(10);
  CHECK(still.position(1) == Vec3d{0, 0, 1});
}
