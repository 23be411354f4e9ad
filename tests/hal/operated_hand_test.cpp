// A hand led by a person follows the target at a limited speed, and rests without a target.
#include "hal/operated_hand.h"

#include <catch2/catch.hpp>

#include "hal/profiles.h"
#include "hal/simulated_device.h"

using namespace tactus;
using namespace tactus::hal;

namespace {

constexpr double kTick_s = 1e-3;

OperatedHand begun(const Vec3d& position = {}) {
  OperatedHand hand;
  hand.begin({{position, {}}, {}});
  return hand;
}

}  // namespace

TEST_CASE("a led hand arrives where it is wished, without overshoot, at rest") {
  OperatedHand hand = begun({0.1, 0, 0});
  hand.wish({0.004, 0, 0}, {0, 0, 0.02});
  double farthest = 0;
  for (int tick = 0; tick < 1000; ++tick) {
    hand.advance(kTick_s);
    farthest = std::max(farthest, hand.at(0).pose.position.x);
  }
  CHECK(hand.at(0).pose.position.x == Approx(0.104).margin(1e-9));
  CHECK(farthest <= 0.104 + 1e-9);  // critically damped
  CHECK(rotation_vector_of(hand.at(0).pose.rotation).z == Approx(0.02).margin(1e-9));
  CHECK(norm(hand.at(0).twist.linear) < 1e-6);
}

TEST_CASE("a led hand is never faster than half a metre a second, whatever is wished") {
  OperatedHand hand = begun();
  double fastest = 0;
  for (int tick = 0; tick < 2000; ++tick) {
    const double far = tick % 200 < 100 ? 5 : -5;
    hand.wish({far, -far, far}, {far, far, 0});
    const Vec3d before = hand.at(0).pose.position;
    hand.advance(kTick_s);
    fastest = std::max(fastest, norm(hand.at(0).pose.position - before) / kTick_s);
    CHECK(norm(hand.at(0).twist.angular) <= OperatedHand::kMaxTurn_rad_per_s * (1 + 1e-9));
  }
  CHECK(fastest <= OperatedHand::kMaxSpeed_m_per_s * (1 + 1e-9));
  CHECK(fastest > 0.99 * OperatedHand::kMaxSpeed_m_per_s);
}

TEST_CASE("held, it comes to rest near where it was") {
  OperatedHand hand = begun();
  hand.wish({1, 0, 0}, {});
  for (int tick = 0; tick < 300; ++tick) hand.advance(kTick_s);
  const double held_at = hand.at(0).pose.position.x;
  hand.hold();
  for (int tick = 0; tick < 1000; ++tick) hand.advance(kTick_s);
  CHECK(norm(hand.at(0).twist.linear) < 1e-6);
  CHECK(std::abs(hand.at(0).pose.position.x - held_at) < 0.5 / 30);  // its speed / what it follows with
}

TEST_CASE("the simulated device's tool follows the hand that is led, from where the script had it") {
  const auto profile = find_profile("virtuose6d");
  REQUIRE(profile);
  HandParameters parameters;
  const std::vector<HandWaypoint> path{{0, {0, 0, 0}, {}}, {1, {0.05, 0, 0}, {}}};
  SimulatedDevice device(*profile, HandModel(parameters, path), {});
  haptics::DeviceInput input;
  for (int tick = 0; tick < 500; ++tick) device.read(input);
  const Vec3d taken_at = device.hand_target().pose.position;
  CHECK(taken_at.x > 0.01);
  device.take_hand();
  CHECK(device.hand_target().pose.position == taken_at);  // no step
  device.lead_hand({0, 0.03, 0}, {});
  for (int tick = 0; tick < 1500; ++tick) device.read(input);
  CHECK(device.hand_is_operated());
  CHECK(device.hand_target().pose.position.x == Approx(taken_at.x).margin(1e-9));
  CHECK(device.hand_target().pose.position.y == Approx(0.03).margin(1e-6));
  CHECK(input.sample.device_from_tool.position.y == Approx(0.03).margin(2e-3));
  device.return_hand();
  CHECK_FALSE(device.hand_is_operated());
}
