#include "hal/hand.h"

#include <catch2/catch.hpp>
#include <limits>
#include <random>
#include <string>

using namespace tactus;
using namespace tactus::hal;

namespace {

const std::vector<HandWaypoint> kPath{{0.5, {0, 0, 0}, {0, 0, 0}},
                                      {1.0, {0.1, 0, 0}, {0, 0, 0.5}},
                                      {3.0, {0.1, -0.2, 0.05}, {0.3, -0.4, 0.1}},
                                      {3.5, {0, 0, 0}, {0, 0, 0}}};

double difference(const Vec3d& a, const Vec3d& b) { return norm(a - b); }
double difference(const Quatd& a, const Quatd& b) { return norm(small_rotation_vector(a * conjugate(b))); }

}  // namespace

TEST_CASE("the target is at each way point at its time and rests there") {
  const HandModel hand({}, kPath);
  for (const HandWaypoint& w : kPath) {
    const HandTarget t = hand.target_at(w.time_s);
    CHECK(difference(t.pose.position, w.position_m) < 1e-15);
    CHECK(difference(t.pose.rotation, quat_from_rotation_vector(w.rotation_vector_rad)) < 1e-14);
    CHECK(norm(t.twist.linear) < 1e-12);
    CHECK(norm(t.twist.angular) < 1e-12);
    const HandTarget before = hand.target_at(w.time_s - 1e-6);  // the end of one segment is the start of the next
    CHECK(difference(before.pose.position, t.pose.position) < 1e-12);
    CHECK(difference(before.pose.rotation, t.pose.rotation) < 1e-12);
  }
}

TEST_CASE("the target rests before its path and after it") {
  const HandModel hand({}, kPath);
  CHECK(hand.target_at(0.0).pose == hand.target_at(0.5).pose);
  CHECK(hand.target_at(1e6).pose == hand.target_at(3.5).pose);
  CHECK(HandModel().target_at(12.0).pose == Posed{});
}

TEST_CASE("a hand that returns sets out where it is, and ends at rest where its path starts") {
  const HandModel hand({}, kPath);
  const Posed from{{0.1, -0.2, 0.05}, quat_from_rotation_vector(Vec3d{0.3, -0.4, 0.1})};
  const double duration_s = hand.return_s(from);
  CHECK(duration_s > norm(from.position) / 0.2);
  CHECK(difference(hand.returning_from(from, 0).pose.position, from.position) < 1e-15);
  CHECK(difference(hand.returning_from(from, 0).pose.rotation, from.rotation) < 1e-14);
  CHECK(norm(hand.returning_from(from, 0).twist.linear) < 1e-12);
  CHECK(difference(hand.returning_from(from, duration_s - 1e-9).pose.position, hand.target_at(0).pose.position) < 1e-9);
  CHECK(hand.returning_from(from, duration_s).pose == hand.target_at(0).pose);
  CHECK(hand.returning_from(from, duration_s).twist.linear == Vec3d{});
}

TEST_CASE("half way in time is half way in space, at 15/8 of the mean speed") {
  const HandModel hand({}, kPath);
  const HandTarget t = hand.target_at(0.75);
  CHECK(difference(t.pose.position, {0.05, 0, 0}) < 1e-15);
  CHECK(t.twist.linear.x == Approx(15.0 / 8.0 * 0.1 / 0.5));
  CHECK(difference(t.pose.rotation, quat_from_rotation_vector(Vec3d{0, 0, 0.25})) < 1e-14);
  CHECK(t.twist.angular.z == Approx(15.0 / 8.0 * 0.5 / 0.5));
}

TEST_CASE("the target's twist is the derivative of its pose, and its acceleration is continuous") {
  const HandModel hand({}, kPath);
  const double dt = 1e-5;
  for (double t = 0.4; t < 3.6; t += 0.00137) {
    const HandTarget before = hand.target_at(t - 0.5 * dt), now = hand.target_at(t),
                     after = hand.target_at(t + 0.5 * dt);
    const Vec3d v = (after.pose.position - before.pose.position) * (1.0 / dt);
    const Vec3d w = small_rotation_vector(after.pose.rotation * conjugate(before.pose.rotation)) * (1.0 / dt);
    REQUIRE(difference(v, now.twist.linear) < 1e-7);
    REQUIRE(difference(w, now.twist.angular) < 1e-7);
    // The jerk of this path is at most 60 x way / duration^3: 60 x 0.1 / 0.5^3 m/s^3, and 60 x 0.6 / 0.5^3 rad/s^3.
    const Vec3d jump = after.twist.linear - now.twist.linear - (now.twist.linear - before.twist.linear);
    REQUIRE(norm(jump) <= 60.0 * 0.25 / 0.125 * dt * dt);
  }
}

TEST_CASE("a path that repeats is periodic") {
  HandParameters p;
  p.repeat = true;
  const HandModel hand(p, kPath);
  for (double t = 0.5; t < 3.5; t += 0.0613) {
    REQUIRE(difference(hand.target_at(t + 3.0).pose.position, hand.target_at(t).pose.position) < 1e-12);
    REQUIRE(difference(hand.target_at(t + 300.0).pose.rotation, hand.target_at(t).pose.rotation) < 1e-10);
  }
}

TEST_CASE("rotation vectors come back from their quaternions, up to half a turn") {
  std::mt19937_64 random(3);
  std::normal_distribution<double> gauss;
  std::uniform_real_distribution<double> angle(0.0, 3.14159);
  for (int i = 0; i < 20000; ++i) {
    const Vec3d axis = normalized_or(Vec3d{gauss(random), gauss(random), gauss(random)}, Vec3d{1, 0, 0});
    const Vec3d v = axis * (i % 10 == 0 ? 1e-9 * angle(random) : angle(random));
    const Quatd q = quat_from_rotation_vector(v);
    REQUIRE(difference(rotation_vector_of(q), v) < 1e-13);
    REQUIRE(difference(rotation_vector_of(Quatd{-q.w, -q.x, -q.y, -q.z}), v) < 1e-13);
  }
  CHECK(rotation_vector_of(Quatd{}) == Vec3d{});
}

TEST_CASE("a path that cannot be followed is refused by number") {
  const auto message = [](HandParameters p, std::vector<HandWaypoint> path) {
    const Status s = HandModel::check(p, path);
    return s.ok() ? std::string() : s.message();
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(message({}, kPath).empty());
  CHECK(message({}, {}).empty());
  CHECK_THAT(message({}, {{0, {}, {}}, {0, {}, {}}}), Catch::Contains("way point 2") && Catch::Contains("after"));
  CHECK_THAT(message({}, {{0, {nan, 0, 0}, {}}}), Catch::Contains("way point 1"));
  CHECK_THAT(message({}, {{-1, {}, {}}}), Catch::Contains("way point 1"));
  HandParameters bad;
  bad.damping_Ns_per_m = -1;
  CHECK_THAT(message(bad, {}), Catch::Contains("not negative"));
  HandParameters repeat;
  repeat.repeat = true;
  CHECK_THAT(message(repeat, {{0, {}, {}}, {1, {1, 0, 0}, {}}}), Catch::Contains("repeats"));
  CHECK(message(repeat, kPath).empty());
}

namespace {

// Uneven times, a turn about another axis in each leg, velocities that no neighbour suggests.
HandModel cubic_hand() {
  HandParameters p;
  p.motion = haptics::HandMotion::kCubic;
  const std::vector<HandWaypoint> path{{0, {0, 0, 0}, {0, 0, 0}, {0.1, 0, 0}, {0, 0.5, 0}},
                                       {0.4, {0.03, 0.01, 0}, {0.3, 0, 0.2}, {0.05, -0.1, 0.02}, {1, 0, -0.5}},
                                       {1.0, {0.02, -0.04, 0.02}, {0.3, 0.9, 0}, {0, 0.2, 0}, {0, 0, 2}},
                                       {1.2, {0, 0, 0}, {0, 0.2, 0}, {}, {}}};
  return HandModel(p, path);
}

}  // namespace

TEST_CASE("a linear target is a share of the way and the turn, at a constant speed in each leg") {
  HandParameters p;
  p.motion = haptics::HandMotion::kLinear;
  const HandModel hand(p, kPath);
  const HandTarget t = hand.target_at(0.6);
  CHECK(difference(t.pose.position, {0.02, 0, 0}) < 1e-15);
  CHECK(difference(t.pose.rotation, quat_from_rotation_vector(Vec3d{0, 0, 0.1})) < 1e-14);
  CHECK(difference(t.twist.linear, {0.2, 0, 0}) < 1e-12);
  CHECK(difference(t.twist.angular, {0, 0, 1}) < 1e-12);
}

TEST_CASE("a cubic target goes through each way point with the velocity that it names") {
  const HandModel hand = cubic_hand();
  const auto at = [&](double t, const Vec3d& x, const Vec3d& r, const Vec3d& v, const Vec3d& w) {
    for (const double side : {-1e-9, 1e-9}) {
      const HandTarget target = hand.target_at(t + side);
      CHECK(difference(target.pose.position, x) < 1e-9);
      CHECK(difference(target.pose.rotation, quat_from_rotation_vector(r)) < 1e-8);
      CHECK(difference(target.twist.linear, v) < 1e-6);
      CHECK(difference(target.twist.angular, w) < 1e-6);
    }
  };
  at(0.4, {0.03, 0.01, 0}, {0.3, 0, 0.2}, {0.05, -0.1, 0.02}, {1, 0, -0.5});
  at(1.0, {0.02, -0.04, 0.02}, {0.3, 0.9, 0}, {0, 0.2, 0}, {0, 0, 2});
  // Hermite half way between two places at distance m with velocities a and b, T apart: m / 2 + T (a - b) / 8.
  CHECK(difference(hand.target_at(0.2).pose.position, Vec3d{0.015, 0.005, 0} + 0.05 * Vec3d{0.05, 0.1, -0.02}) < 1e-15);
}

TEST_CASE("a cubic target's twist is the derivative of its pose") {
  const HandModel hand = cubic_hand();
  const double dt = 1e-5;
  for (double t = 0.01; t < 1.19; t += 0.00137) {
    if (std::abs(t - 0.4) < dt || std::abs(t - 1.0) < dt) continue;  // there the acceleration steps
    const HandTarget before = hand.target_at(t - 0.5 * dt), now = hand.target_at(t),
                     after = hand.target_at(t + 0.5 * dt);
    const Vec3d v = (after.pose.position - before.pose.position) * (1.0 / dt);
    const Vec3d w = small_rotation_vector(after.pose.rotation * conjugate(before.pose.rotation)) * (1.0 / dt);
    REQUIRE(difference(v, now.twist.linear) < 1e-7);
    REQUIRE(difference(w, now.twist.angular) < 1e-7);
  }
}

TEST_CASE("the rate of a rotation vector and the angular velocity are each other's inverse") {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> number(-1.5, 1.5);
  for (int i = 0; i < 1000; ++i) {
    const double size = i % 4 == 0 ? 1e-4 : 1;
    const Vec3d r = Vec3d{number(random), number(random), number(random)} * size;
    const Vec3d w{number(random), number(random), number(random)};
    REQUIRE(difference(angular_velocity_of(r, rate_of_rotation_vector(r, w)), w) < 1e-12);
  }
}
