#include <catch2/catch.hpp>

#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::PhysicsBench;
using tactus::test::Random;

TEST_CASE("Kinetic energy is half m v^2 and half I w^2 of every body, also when it is turned") {
  PhysicsBench bench;
  bench.add_sphere(1, 0.1, 2, 0.5, {}, {3, 0, 4});  // 25 J
  CHECK(bench.world.kinetic_energy() == Approx(25));
  // A box 2 x 4 x 6 of 12 kg: I = m/3 (b^2 + c^2) = 4 (4 + 9, 1 + 9, 1 + 4), turned a quarter about z: its y axis is x.
  const Quatd turned = quat_from_rotation_vector(Vec3d{0, 0, tactus::test::kPi / 2});
  bench.add_box(2, {1, 2, 3}, 12, 0.5, {{0, 0, 20}, turned}, {{}, {2, 0, 0}});
  CHECK(bench.world.kinetic_energy() == Approx(25 + 0.5 * 40 * 4));
}

TEST_CASE("Potential energy is - m g x, of what falls") {
  PhysicsBench bench;
  bench.add_sphere(1, 0.1, 2, 0.5, {1, 2, 3});
  bench.add_sphere(2, 0.1, 5, 0.5, {1, 2, 30});
  bench.body(2).gravity_scale = 0;
  CHECK(bench.world.potential_energy({0, 0, -10}) == Approx(60));
  CHECK(bench.world.potential_energy({1, 0, 0}) == Approx(-2));
}

TEST_CASE("Momentum is m v, and about the origin x cross m v and the spin") {
  PhysicsBench bench;
  bench.add_sphere(1, 0.5, 2, 0.5, {1, 0, 0}, {0, 3, 0});
  bench.velocity(1).angular = {0, 0, 7};  // I = 0.4 m r^2 = 0.2
  const Wrenchd momentum = bench.world.momentum();
  CHECK(norm(momentum.force - Vec3d{0, 6, 0}) < 1e-12);
  CHECK(norm(momentum.torque - Vec3d{0, 0, 6 + 1.4}) < 1e-12);
}

TEST_CASE("An impulse changes the momentum by itself, also of a turned body") {
  Random random(4);
  for (int k = 0; k < 20; ++k) {
    PhysicsBench bench;
    bench.add_box(1, {0.1, 0.2, 0.3}, 1.5, 0.5, {{}, quat_from_rotation_vector(random.vector(2))},
                  {random.vector(1), random.vector(1)});
    const Wrenchd before = bench.world.momentum(), impulse{random.vector(1), random.vector(1)};
    bench.world.apply_impulse(SlotIndex{0}, impulse);
    CHECK(norm(bench.world.momentum().force - before.force - impulse.force) < 1e-12);
    CHECK(norm(bench.world.momentum().torque - before.torque - impulse.torque) < 1e-12);
  }
}

TEST_CASE("Free flight keeps momentum and energy, rotation included") {
  PhysicsBench bench;
  bench.settings.gravity = {};
  Random random(5);
  for (BodyId id = 0; id < 5; ++id)
    bench.add_box(id, {0.1, 0.07, 0.05}, 1, 0.5, {{10.0 * id, 0, 0}, {}}, {random.vector(1), random.vector(3)});
  const Wrenchd before = bench.world.momentum();
  const double energy = bench.world.kinetic_energy();
  bench.run(2000);
  CHECK(norm(bench.world.momentum().force - before.force) == 0);
  CHECK(norm(bench.world.momentum().torque - before.torque) < 1e-9 * norm(before.torque));
  CHECK(bench.world.kinetic_energy() == Approx(energy).epsilon(1e-9));
}

TEST_CASE("The hash of the state changes with every bit that counts, and with nothing else") {
  PhysicsBench bench;
  bench.add_sphere(1, 0.1, 1, 0.5, {1, 2, 3}, {4, 5, 6});
  bench.add_sphere(2, 0.1, 1, 0.5, {2, 2, 3});
  const std::uint64_t hash = bench.world.state_hash();
  BodyMotion& motion = bench.body(1).motion;
  double* const fields[] = {&motion.pose.position.x,   &motion.pose.position.y,    &motion.pose.position.z,
                            &motion.pose.rotation.w,   &motion.pose.rotation.x,    &motion.pose.rotation.y,
                            &motion.pose.rotation.z,   &motion.velocity.linear.x,  &motion.velocity.linear.y,
                            &motion.velocity.linear.z, &motion.velocity.angular.x, &motion.velocity.angular.y,
                            &motion.velocity.angular.z};
  for (double* field : fields) {
    const double was = *field;
    *field = std::nextafter(was, 10.0);
    CHECK(bench.world.state_hash() != hash);
    *field = was;
  }
  bench.body(1).friction = 0.9;
  CHECK(bench.world.state_hash() == hash);
  bench.body(2).id = 3;
  CHECK(bench.world.state_hash() != hash);
}

TEST_CASE("The hash is FNV-1a of ids, poses and velocities") {
  PhysicsBench bench;
  CHECK(bench.world.state_hash() == 0xcbf29ce484222325ull);  // the offset basis, of nothing
}
