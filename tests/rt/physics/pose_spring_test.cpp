#include "rt/physics/pose_spring.h"

#include <catch2/catch.hpp>

#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::kGravity;
using tactus::test::PhysicsBench;

namespace {

// One free sphere on a spring, no gravity.
void add_body_on_spring(PhysicsBench& bench, double stiffness, double damping) {
  bench.settings.gravity = {};
  bench.add_sphere(5, 0.02, 0.2, 0.5, {});
  PoseSpring& spring = bench.world.device_spring();
  spring.enabled = true;
  spring.slot = bench.slot(5);
  spring.stiffness_N_per_m = stiffness;
  spring.damping_Ns_per_m = damping;
}

}  // namespace

TEST_CASE("A mass on the device spring follows implicit Euler, sub-step by sub-step") {
  const double k = 2000, b = 5, m = 0.2;
  PhysicsBench bench;
  add_body_on_spring(bench, k, b);
  PoseSpring& spring = bench.world.device_spring();
  spring.target.position = {0.01, 0, -0.02};
  const double h = bench.h();
  double x = 0, v = 0;
  for (int step = 0; step < 300; ++step) {
    double impulse = 0;
    for (unsigned j = 0; j < bench.settings.sub_steps; ++j) {
      // m (v' - v) = -h K (x + h v' - x_t) - h B v'
      const double next = (m * v - h * k * (x - 0.01)) / (m + h * b + h * h * k);
      impulse += m * (next - v);
      v = next;
      x += h * v;
    }
    bench.step();
    REQUIRE(bench.position(5).x == Approx(x).epsilon(1e-9));
    REQUIRE(bench.velocity(5).linear.x == Approx(v).epsilon(1e-9).margin(1e-12));
    REQUIRE(bench.position(5).z == Approx(-2 * x).epsilon(1e-9));
    REQUIRE(spring.step_impulse.force.x == Approx(impulse).epsilon(1e-9).margin(1e-12));
  }
}

TEST_CASE("The device spring turns a body by implicit Euler as well") {
  const double k = 5, b = 0.02;
  PhysicsBench bench;
  add_body_on_spring(bench, 0, 0);
  PoseSpring& spring = bench.world.device_spring();
  spring.stiffness_Nm_per_rad = k;
  spring.damping_Nms_per_rad = b;
  const double angle = 1e-3, inertia = bench.body(5).inertia.x, h = bench.h();
  spring.target.rotation = quat_from_rotation_vector(Vec3d{0, angle, 0});
  double x = 0, v = 0;
  for (int step = 0; step < 200; ++step) {
    for (unsigned j = 0; j < bench.settings.sub_steps; ++j) {
      v = (inertia * v - h * k * (x - angle)) / (inertia + h * b + h * h * k);
      x += h * v;
    }
    bench.step();
    // Twice the sine of half the angle for the angle: less than 1e-6 of it here.
    REQUIRE(small_rotation_vector(bench.body(5).motion.pose.rotation).y == Approx(x).epsilon(1e-5).margin(1e-12));
  }
  CHECK(bench.position(5) == Vec3d{});
  spring.target.rotation = quat_from_rotation_vector(Vec3d{0, 2.5, 0});  // a large turn: the short way round
  bench.run(2000);
  CHECK(norm(small_rotation_vector(bench.body(5).motion.pose.rotation * conjugate(spring.target.rotation))) < 1e-6);
}

TEST_CASE("The device spring is stable for every stiffness and damping") {
  for (const double k : {0.0, 1.0, 1e3, 1e5, 1e7})
    for (const double b : {0.0, 1.0, 1e2, 1e4}) {
      PhysicsBench bench;
      add_body_on_spring(bench, k, b);
      PoseSpring& spring = bench.world.device_spring();
      spring.stiffness_Nm_per_rad = k;
      spring.damping_Nms_per_rad = b;
      spring.target = {{0.1, 0, 0}, quat_from_rotation_vector(Vec3d{0, 0, 0.5})};
      double worst = 0;
      for (int step = 0; step < 1000; ++step) {
        bench.step();
        worst = std::max(worst, bench.world.kinetic_energy());
      }
      // Implicit Euler gains nothing: never more than the energy that the spring was stretched with. The rotation's
      // error is 2 sin of half the angle, so its energy is at most that of the angle.
      CHECK(worst <= 0.5 * k * 0.01 + 0.5 * k * 0.25 + 1e-15);
      if (k >= 1e3 && b >= 1) CHECK(norm(bench.position(5) - spring.target.position) < 0.1);
    }
}

TEST_CASE("A body on the spring follows a moving target without lag, and what it gets is the momentum it gains") {
  PhysicsBench bench;
  add_body_on_spring(bench, 2000, 40);
  PoseSpring& spring = bench.world.device_spring();
  spring.stiffness_Nm_per_rad = 5;
  spring.damping_Nms_per_rad = 0.02;
  const Twistd velocity{{0.3, -0.1, 0}, {0, 0, 2}};
  spring.target_velocity = velocity;
  Vec3d gained;
  for (int step = 0; step < 1000; ++step) {
    bench.step();
    gained += spring.step_impulse.force;
    spring.target.position += bench.settings.dt * velocity.linear;
    spring.target.rotation = quat_from_rotation_vector(bench.settings.dt * velocity.angular) * spring.target.rotation;
  }
  CHECK(norm(bench.velocity(5).linear - velocity.linear) < 1e-6);
  CHECK(norm(bench.position(5) - spring.target.position) < 1e-6);
  CHECK(norm(small_rotation_vector(bench.body(5).motion.pose.rotation * conjugate(spring.target.rotation))) < 1e-4);
  CHECK(norm(gained - 0.2 * bench.velocity(5).linear) < 1e-12);
}

TEST_CASE("A body hung on the spring sags by m g / K and weighs m g in its impulse") {
  PhysicsBench bench;
  add_body_on_spring(bench, 2000, 20);
  bench.settings.gravity = {0, 0, -kGravity};
  bench.run(2000);
  CHECK(bench.position(5).z == Approx(-0.2 * kGravity / 2000).epsilon(1e-6));
  CHECK(bench.world.device_spring().step_impulse.force.z / bench.settings.dt == Approx(0.2 * kGravity).epsilon(1e-6));
}

TEST_CASE("Pressed against the ground the spring's force is what the ground carries") {
  PhysicsBench bench;
  bench.add_ground(0, 0.5);
  add_body_on_spring(bench, 2000, 20);
  bench.position(5).z = 0.02;
  bench.world.device_spring().target.position = {0, 0, 0.02 - 0.005};
  bench.run(2000);
  const double overlap = bench.overlap_under(10 - 2000 * 2e-5, 0.2);  // the spring is shorter by the overlap
  CHECK(0.02 - bench.position(5).z == Approx(overlap).epsilon(0.02));
  const double force = bench.world.device_spring().step_impulse.force.z / bench.settings.dt;
  CHECK(force == Approx(-2000 * (0.005 - (0.02 - bench.position(5).z))).epsilon(1e-4));
  REQUIRE(bench.world.contacts().size() == 1);
  CHECK(bench.world.contacts()[0].points[0].total_normal_impulse / bench.settings.dt == Approx(-force).epsilon(1e-6));
  for (const unsigned sub_steps : {8u, 2u, 4u}) {  // the balance of the two survives a change of the sub-step
    bench.settings.sub_steps = sub_steps;
    bench.step();
    CHECK(bench.world.device_spring().step_impulse.force.z / bench.settings.dt == Approx(force).epsilon(1e-5));
    CHECK(std::abs(bench.velocity(5).linear.z) < 1e-9);
  }
}

TEST_CASE("A frozen body holds against the spring, whose force is still K e") {
  PhysicsBench bench;
  add_body_on_spring(bench, 2000, 0);
  bench.world.device_spring().target.position = {0.01, 0, 0};
  bench.world.set_frozen(bench.slot(5), true);
  bench.run(3);
  CHECK(bench.position(5) == Vec3d{});
  CHECK(bench.world.device_spring().step_impulse.force.x / bench.settings.dt == Approx(20).epsilon(1e-9));
}

TEST_CASE("A spring that is off, or has no gains, does nothing and holds no impulse") {
  PhysicsBench bench;
  add_body_on_spring(bench, 2000, 5);
  PoseSpring& spring = bench.world.device_spring();
  spring.target.position = {0.01, 0, 0};
  bench.run(1);
  const Vec3d velocity = bench.velocity(5).linear;
  REQUIRE(velocity.x > 0);
  spring.stiffness_N_per_m = spring.damping_Ns_per_m = 0;
  bench.run(1);
  CHECK(bench.velocity(5).linear == velocity);
  CHECK(spring.step_impulse == Wrenchd{});
  spring.stiffness_N_per_m = 2000;
  spring.enabled = false;
  bench.run(1);
  CHECK(bench.velocity(5).linear == velocity);
  CHECK(spring.step_impulse == Wrenchd{});
}

TEST_CASE("The spring's force does not jump when the number of sub-steps changes") {
  PhysicsBench bench;
  add_body_on_spring(bench, 2000, 20);
  bench.settings.gravity = {0, 0, -kGravity};
  bench.run(3000);
  for (const unsigned sub_steps : {8u, 2u, 4u}) {
    bench.settings.sub_steps = sub_steps;
    bench.step();
    CHECK(bench.world.device_spring().step_impulse.force.z / bench.settings.dt == Approx(0.2 * kGravity).epsilon(1e-6));
  }
}
