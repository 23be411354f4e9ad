#include "rt/haptics/device_placement.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "tests/support/random.h"

using namespace tactus;
using namespace tactus::haptics;
using test::Random;

namespace {

DevicePlacement random_placement(Random& random, bool has_rotation = true) {
  DevicePlacement placement{};
  placement.config = {random.pose(), std::exp(random.symmetric(3)), has_rotation};
  placement.clutch_to(random.pose(), random.pose());
  return placement;
}

// Angle-free distance of two rotations.
double apart(const Quatd& a, const Quatd& b) { return norm((a * conjugate(b)).vec()); }

}  // namespace

TEST_CASE("the power at the hand is the power in the world") {
  Random random(21);
  for (int i = 0; i < 2000; ++i) {
    const DevicePlacement placement = random_placement(random, i % 4 != 0);
    const Twistd tool{random.vector(), random.vector(10)};
    const Wrenchd world{random.vector(30), random.vector(3)};
    const Twistd target = placement.target_twist(tool);
    const Wrenchd hand = placement.device_wrench(world);
    const double at_hand = dot(hand.force, tool.linear) + dot(hand.torque, tool.angular);
    const double in_world = dot(world.force, target.linear) + dot(world.torque, target.angular);
    const double size = norm(world.force) * norm(target.linear) + norm(world.torque) * norm(tool.angular);
    REQUIRE(std::abs(at_hand - in_world) <= 1e-14 * size);
  }
}

TEST_CASE("the target's twist is the rate of the target's pose") {
  Random random(21);
  for (int i = 0; i < 500; ++i) {
    const DevicePlacement placement = random_placement(random);
    const Posed tool = random.pose();
    const Twistd twist{random.vector(), random.vector()};
    const double dt = 1e-6;
    const Posed later{tool.position + twist.linear * dt, quat_from_rotation_vector(twist.angular * dt) * tool.rotation};
    const Posed a = placement.world_from_target(tool), b = placement.world_from_target(later);
    const Twistd target = placement.target_twist(twist);
    REQUIRE(norm((b.position - a.position) * (1 / dt) - target.linear) < 1e-7 * placement.config.motion_scale);
    REQUIRE(norm(small_rotation_vector(b.rotation * conjugate(a.rotation)) * (1 / dt) - target.angular) < 1e-7);
  }
}

TEST_CASE("without a clutch the target is the scaled tool in the device's place") {
  DevicePlacement placement{};
  placement.config.world_from_device = {{1, 2, 3}, quat_from_rotation_vector(Vec3d{0, 0, 3.14159265358979323846 / 2})};
  placement.config.motion_scale = 5;
  const Posed target = placement.world_from_target({{0.1, 0, 0}, {}});
  CHECK(norm(target.position - Vec3d{1, 2.5, 3}) < 1e-14);
  CHECK(apart(target.rotation, placement.config.world_from_device.rotation) < 1e-14);
  const Wrenchd hand = placement.device_wrench({{0, 2, 0}, {0, 1, 0}});
  CHECK(norm(hand.force - Vec3d{10, 0, 0}) < 1e-14);  // five times the force for a fifth of the way
  CHECK(norm(hand.torque - Vec3d{1, 0, 0}) < 1e-14);
}

TEST_CASE("a clutch moves the target to the requested pose, from anywhere and repeatedly") {
  Random random(21);
  DevicePlacement placement{};
  for (int i = 0; i < 2000; ++i) {
    placement.config = {random.pose(), std::exp(random.symmetric(3)), true};
    const Posed wanted = random.pose(), tool = random.pose();
    placement.clutch_to(wanted, tool);
    const Posed target = placement.world_from_target(tool);
    REQUIRE(norm(target.position - wanted.position) < 1e-13);
    REQUIRE(apart(target.rotation, wanted.rotation) < 1e-14);
    REQUIRE(std::abs(norm(target.rotation) - 1) < 1e-15);
  }
}

TEST_CASE("a clutch does not turn the axis about which the hand turns the target") {
  Random random(21);
  for (int i = 0; i < 200; ++i) {
    DevicePlacement placement{};
    placement.clutch_to(random.pose(), random.pose());
    const Quatd tool = random.rotation(), turn = quat_from_rotation_vector(random.vector(0.5));
    const Quatd before = placement.world_from_target({{}, tool}).rotation;
    const Quatd after = placement.world_from_target({{}, turn * tool}).rotation;
    REQUIRE(apart(after * conjugate(before), turn) < 1e-14);
  }
}

TEST_CASE("a three-degree-of-freedom device keeps the target's orientation and gets no torque") {
  Random random(21);
  const DevicePlacement start = random_placement(random, false);
  const Quatd held = start.world_from_target(random.pose()).rotation;
  for (int i = 0; i < 100; ++i) {
    CHECK(start.world_from_target(random.pose()).rotation == held);
    CHECK(start.target_twist({random.vector(), random.vector()}).angular == Vec3d{});
    CHECK(start.device_wrench({random.vector(), random.vector()}).torque == Vec3d{});
  }
  DevicePlacement clutched = start;
  const Posed wanted = random.pose();
  clutched.clutch_to(wanted, random.pose());
  CHECK(apart(clutched.world_from_target(random.pose()).rotation, wanted.rotation) < 1e-14);
}
