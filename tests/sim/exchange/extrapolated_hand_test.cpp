#include "sim/exchange/extrapolated_hand.h"

#include <catch2/catch.hpp>

#include "rt/base/rotation_vector.h"

using namespace tactus;
using namespace tactus::sim;
using haptics::DeviceTarget;

namespace {

constexpr double kCycle_s = 0.016;
const Twistd kVelocity{{0.1, -0.2, 0.05}, {0, 0, 0.5}}, kAcceleration{{1.5, 0.5, -1}, {0, 0, 20}};

// A hand with constant acceleration, about one axis, `time_s` after it was at the origin.
DeviceTarget pushed(double time_s) {
  const Twistd mean = kVelocity + kAcceleration * (0.5 * time_s);
  return {true,
          {time_s * mean.linear, quat_from_rotation_vector(time_s * mean.angular)},
          kVelocity + kAcceleration * time_s};
}

DeviceTarget at_velocity(const Vec3d& linear) { return {true, {}, {linear, {}}}; }

ExtrapolatedHand after_cycles(std::initializer_list<double> speeds_m_per_s) {
  ExtrapolatedHand hand;
  for (const double speed : speeds_m_per_s) hand.take(at_velocity({0, speed, 0}), kCycle_s);
  return hand;
}

void check_close(const DeviceTarget& found, const DeviceTarget& known) {
  CHECK(norm(found.pose.position - known.pose.position) < 1e-15);
  CHECK(norm(rotation_vector_of(found.pose.rotation * conjugate(known.pose.rotation))) < 1e-14);
  CHECK(norm(found.velocity.linear - known.velocity.linear) < 1e-13);
  CHECK(norm(found.velocity.angular - known.velocity.angular) < 1e-13);
}

}  // namespace

TEST_CASE("A hand that accelerates steadily is where the extrapolation says, from the third report on") {
  ExtrapolatedHand hand;
  for (int cycle = 0; cycle < 4; ++cycle) {
    hand.take(pushed(cycle * kCycle_s), cycle == 0 ? 0 : kCycle_s);
    if (cycle < 2) {
      CHECK(hand.acceleration == Twistd{});
      continue;
    }
    for (const double time_s : {0.0, 0.3 * kCycle_s, kCycle_s})
      check_close(hand.after(time_s), pushed(cycle * kCycle_s + time_s));
  }
}

TEST_CASE("An impact and a tremor are not extrapolated, a change by half is") {
  CHECK(after_cycles({0.2, 0.2, 0.05}).acceleration == Twistd{});        // stopped by an impact
  CHECK(after_cycles({0.2, 0.2, 0.05, 0.05}).acceleration == Twistd{});  // and free of it
  CHECK(after_cycles({0.2, 0.18, 0.2, 0.18}).acceleration == Twistd{});  // to and fro
  CHECK(after_cycles({0.2, 0.18, 0.1699}).acceleration.linear.y == Approx(-0.0101 / kCycle_s));
  CHECK(after_cycles({0.2, 0.18, 0.1701}).acceleration == Twistd{});
  const DeviceTarget then = after_cycles({0.2, 0.2, 0.05}).after(kCycle_s);
  CHECK(then.pose.position.y == Approx(0.05 * kCycle_s));
  CHECK(then.velocity.linear.y == 0.05);
}

TEST_CASE(
    "A hand that is not engaged stays where it is, and its acceleration is not known before the third report after") {
  ExtrapolatedHand hand;
  for (int cycle = 0; cycle < 3; ++cycle) hand.take(pushed(cycle * kCycle_s), kCycle_s);
  REQUIRE(hand.acceleration != Twistd{});
  DeviceTarget released = pushed(3 * kCycle_s);
  released.engaged = false;
  hand.take(released, kCycle_s);
  CHECK(hand.acceleration == Twistd{});
  CHECK_FALSE(hand.after(kCycle_s).engaged);
  CHECK(hand.after(kCycle_s).pose.position == released.pose.position);
  for (int cycle = 4; cycle < 7; ++cycle) {
    hand.take(pushed(cycle * kCycle_s), kCycle_s);
    CHECK((hand.acceleration == Twistd{}) == (cycle < 6));
  }
}
