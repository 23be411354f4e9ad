#include "hal/kinematics/kinematics.h"

#include <catch2/catch.hpp>
#include <functional>

#include "hal/profiles.h"
#include "tests/support/random.h"

using namespace tactus;
using namespace tactus::hal;
using test::Random;

namespace {

constexpr double kPi = 3.14159265358979323846;
const ArmLinks kLinks{0.45, 0.4};
const CartesianStage kStage;
const WristedArm kArm(kLinks);
const PointArm kPoint(kLinks);

AxisVector random_rates(Random& random) {
  AxisVector rates;
  for (unsigned k = 0; k < kAxisCount; ++k) rates[k] = random.symmetric(k < 3 ? 1 : 9);
  return rates;
}
// Away from the singularities, whatever the kind: an arm's elbow within 70 degrees of its right angle.
AxisVector random_coordinates(Random& random) {
  const AxisVector most{1, 0.6, 0.6, kPi, kPitchLimit_rad, kPi};
  AxisVector coordinates;
  for (unsigned k = 0; k < kAxisCount; ++k) coordinates[k] = random.symmetric(most[k]);
  return coordinates;
}

double product(const AxisVector& a, const AxisVector& b) {
  double sum = 0;
  for (unsigned i = 0; i < kAxisCount; ++i) sum += a[i] * b[i];
  return sum;
}

void check_close(const Vec3d& a, const Vec3d& b, double margin) {
  REQUIRE(a.x == Approx(b.x).margin(margin));
  REQUIRE(a.y == Approx(b.y).margin(margin));
  REQUIRE(a.z == Approx(b.z).margin(margin));
}

// Of each kind, in every configuration that the test draws.
void for_each_kind(const std::function<void(const Kinematics&, bool has_rotation)>& check) {
  SECTION("stage") { check(kStage, true); }
  SECTION("arm with a wrist") { check(kArm, true); }
  SECTION("arm without") { check(kPoint, false); }
}

}  // namespace

TEST_CASE("axis efforts do the work of the wrench in every configuration") {
  for_each_kind([](const Kinematics& kinematics, bool) {
    Random random(7);
    for (int i = 0; i < 20000; ++i) {
      AxisVector q = random_coordinates(random);
      if (i % 4 == 0) {  // singular ones as well
        q[1] = random(-kPi, kPi);
        q[2] = random(-kPi, kPi);
      }
      const AxisVector rate = random_rates(random);
      const Wrenchd wrench{random.vector(35), random.vector(3)};
      const Twistd twist = kinematics.twist_of(q, rate);
      const double power = dot(wrench.force, twist.linear) + dot(wrench.torque, twist.angular);
      REQUIRE(product(kinematics.efforts_of(q, wrench), rate) == Approx(power).margin(1e-10));
    }
  });
}

TEST_CASE("the Jacobian is the derivative of the pose") {
  for_each_kind([](const Kinematics& kinematics, bool) {
    Random random(7);
    const double dt = 1e-6;
    for (int i = 0; i < 2000; ++i) {
      const AxisVector q = random_coordinates(random), rate = random_rates(random);
      AxisVector before = q, after = q;
      for (unsigned k = 0; k < kAxisCount; ++k) {
        before[k] -= 0.5 * dt * rate[k];
        after[k] += 0.5 * dt * rate[k];
      }
      const Posed a = kinematics.pose_of(before), b = kinematics.pose_of(after);
      const Twistd twist = kinematics.twist_of(q, rate);
      check_close((b.position - a.position) * (1.0 / dt), twist.linear, 1e-8);
      check_close(small_rotation_vector(b.rotation * conjugate(a.rotation)) * (1.0 / dt), twist.angular, 1e-7);
    }
  });
}

TEST_CASE("rates and wrenches come back from twists and efforts up to the pitch limit") {
  for_each_kind([](const Kinematics& kinematics, bool has_rotation) {
    Random random(7);
    for (int i = 0; i < 20000; ++i) {
      AxisVector q = random_coordinates(random);
      if (i % 10 == 0) q[4] = i % 20 == 0 ? kPitchLimit_rad : -kPitchLimit_rad;
      const AxisVector rate = random_rates(random), back = kinematics.rates_of(q, kinematics.twist_of(q, rate));
      for (unsigned k = 0; k < kAxisCount; ++k)
        REQUIRE(back[k] == Approx(k < 3 || has_rotation ? rate[k] : 0.0).margin(1e-12));
      const Wrenchd wrench{random.vector(35), random.vector(3)},
          again = kinematics.wrench_of(q, kinematics.efforts_of(q, wrench));
      check_close(again.force, wrench.force, 1e-11);
      check_close(again.torque, has_rotation ? wrench.torque : Vec3d{}, 1e-11);
    }
  });
}

TEST_CASE("yaw turns x to y, pitch x to -z, roll y to z") {
  const Vec3d x{1, 0, 0}, y{0, 1, 0};
  for (const Kinematics& kinematics : {Kinematics(kStage), Kinematics(kArm)}) {
    const auto turned = [&](double yaw, double pitch, double roll, const Vec3d& v) {
      return rotate(kinematics.pose_of({0, 0, 0, yaw, pitch, roll}).rotation, v);
    };
    check_close(turned(kPi / 2, 0, 0, x), {0, 1, 0}, 1e-15);
    check_close(turned(0, kPi / 2, 0, x), {0, 0, -1}, 1e-15);
    check_close(turned(0, 0, kPi / 2, y), {0, 0, 1}, 1e-15);
    check_close(turned(kPi / 2, 0, kPi / 2, y), {0, 0, 1}, 1e-15);  // roll first, then yaw
  }
  CHECK(kStage.pose_of({1, 2, 3, 0, 0, 0}).position == Vec3d{1, 2, 3});
}

TEST_CASE("an arm at rest has its tool at the origin, and its axes move it along y, x and z by the links' lengths") {
  for (const Kinematics& kinematics : {Kinematics(kArm), Kinematics(kPoint)}) {
    CHECK(kinematics.pose_of({}) == Posed{});
    CHECK(kinematics.twist_of({}, unit_axis(0)).linear == Vec3d{0, 0.4, 0});
    CHECK(kinematics.twist_of({}, unit_axis(1)).linear == Vec3d{0.45, 0, 0});
    CHECK(kinematics.twist_of({}, unit_axis(2)).linear == Vec3d{0, 0, 0.4});
  }
}

TEST_CASE("an arm's tool is where its links end") {
  // Yawed by a quarter, upper arm leaning by 30 degrees, forearm down by 30: reach 0.45/2 + 0.4 cos 30 to the side of
  // the column at x = -0.4, height 0.45 cos 30 - 0.4/2 above the shoulder at z = -0.45.
  const AxisVector q{kPi / 2, kPi / 6, -kPi / 6, 0, 0, 0};
  const double root = std::sqrt(3.0) / 2;
  check_close(kArm.pose_of(q).position, {-0.4, 0.225 + 0.4 * root, -0.45 + 0.45 * root - 0.2}, 1e-15);
  check_close(kPoint.pose_of(q).position, kArm.pose_of(q).position, 0);
  // The wrist's base goes with the forearm: its x is the forearm's direction, its y the tangent.
  check_close(rotate(kArm.pose_of(q).rotation, {1, 0, 0}), {0, root, -0.5}, 1e-15);
  check_close(rotate(kArm.pose_of(q).rotation, {0, 1, 0}), {-1, 0, 0}, 1e-15);
  CHECK(kPoint.pose_of(q).rotation == Quatd{});
}

TEST_CASE("the singular wrist gives finite answers") {
  for (const double pitch : {kPi / 2, -kPi / 2, 1.5, 2e5}) {
    const AxisVector q{0, 0, 0, 0.3, pitch, 0.2};
    for (const Kinematics& kinematics : {Kinematics(kStage), Kinematics(kArm)}) {
      const AxisVector rates = kinematics.rates_of(q, {{}, {10, 10, 10}});
      for (const double rate : rates) CHECK(std::abs(rate) < 10.0 * 3 / kCosPitchLimit + 10);
      const Wrenchd wrench = kinematics.wrench_of(q, {0, 0, 0, 3, 3, 3});
      CHECK(norm(wrench.torque) < 6.0 / kCosPitchLimit + 6);
    }
  }
}

TEST_CASE("a stretched, a folded and an upright arm have results within the header's bounds") {
  // 1 m/s: the yaw turns at 1 / (0.1 forearm) at most, the others at 1 / (link x 0.17).
  const double arm_rate = 1.0 / (0.4 * kCosPitchLimit) + 1e-12, yaw_rate = 1.0 / (0.1 * 0.4) + 1e-12;
  Random random(7);
  for (int i = 0; i < 20000; ++i) {
    AxisVector q = random_coordinates(random);
    q[1] = random(-kPi, kPi);
    if (i % 3 == 0) q[2] = kPi / 2 - q[1];                           // stretched
    if (i % 3 == 1) q[2] = -kPi / 2 - q[1];                          // folded
    if (i % 3 == 2) q[1] = std::asin(-0.4 / 0.45 * std::cos(q[2]));  // the tool above the column
    for (const Kinematics& kinematics : {Kinematics(kArm), Kinematics(kPoint)}) {
      const AxisVector rate = kinematics.rates_of(q, {random.direction(), {}});
      REQUIRE(std::abs(rate[0]) <= yaw_rate);
      REQUIRE(std::abs(rate[1]) <= arm_rate);
      REQUIRE(std::abs(rate[2]) <= arm_rate);
      const Wrenchd wrench = kinematics.wrench_of(q, {1, 0, 0, 0, 0, 0});
      REQUIRE(norm(wrench.force) <= yaw_rate);
    }
  }
}

TEST_CASE("a workspace as large as the links allow has exact inverses everywhere") {
  Random random(7);
  for (const ArmLinks links : {ArmLinks{0.45, 0.45}, ArmLinks{0.3, 0.5}, ArmLinks{0.5, 0.2}, ArmLinks{0.16, 0.16}}) {
    const PointArm arm(links);
    const double radius = largest_workspace_m(links);
    CHECK(radius > 0.3 * std::min(links.upper_m, links.forearm_m));
    for (int i = 0; i < 2000; ++i) {
      const Vec3d place = random.direction() * (radius * (i % 2 == 0 ? 1.0 : std::cbrt(random(0, 1))));
      const AxisVector q = coordinates_of(arm, {place, {}});
      REQUIRE(norm(arm.pose_of(q).position - place) < 1e-13);
      const ArmAt at(q, links);
      REQUIRE(at.radius == at.bounded_radius);
      REQUIRE(at.cos_elbow >= kCosPitchLimit);
      REQUIRE(std::abs(at.cos_elbow - (std::cos(q[1] + q[2]))) < 1e-9);
    }
    CHECK(ArmAt(coordinates_of(arm, {}), links).cos_elbow == Approx(1.0));
  }
}

TEST_CASE("the coordinates of a pose give the pose") {
  for_each_kind([](const Kinematics& kinematics, bool has_rotation) {
    Random random(7);
    for (int i = 0; i < 500; ++i) {
      AxisVector q = random_coordinates(random);
      for (unsigned k = 0; k < 3; ++k) q[k] *= 0.5;
      q[4] *= 0.95;
      const Posed pose = kinematics.pose_of(q), back = kinematics.pose_of(coordinates_of(kinematics, pose));
      REQUIRE(norm(back.position - pose.position) < 1e-13);
      REQUIRE(norm(small_rotation_vector(back.rotation * conjugate(pose.rotation))) < (has_rotation ? 1e-12 : 1e-15));
    }
  });
}

TEST_CASE("the bounds of a whole workspace hold at poses that were not sampled") {
  for (const DeviceProfile& profile : all_profiles()) {
    CAPTURE(profile.name);
    Random random(7);
    const haptics::DeviceProperties& p = profile.properties;
    for (int i = 0; i < 20000; ++i) {
      const Vec3d place = random.direction() * (p.workspace_radius_m * std::cbrt(random(0, 1)));
      AxisVector q = coordinates_of(profile.kinematics, {place, {}});
      for (unsigned k = 3; k < kAxisCount; ++k) q[k] = 0;
      const AxisVector rate = profile.kinematics.rates_of(
          q, {random.direction() * p.max_speed_m_per_s, random.direction() * p.max_angular_speed_rad_per_s});
      for (unsigned k = 0; k < kAxisCount; ++k) REQUIRE(std::abs(rate[k]) <= profile.bounds.rate[k]);

      q[3] = random(-kPi, kPi);
      q[4] = random(-kPitchLimit_rad, kPitchLimit_rad);
      q[5] = random(-kPi, kPi);
      const AxisVector effort =
          profile.kinematics.efforts_of(q, {random.direction() * p.max_force_N, random.direction() * p.max_torque_Nm});
      for (unsigned k = 0; k < kAxisCount; ++k) REQUIRE(std::abs(effort[k]) <= profile.bounds.effort[k]);
      REQUIRE(std::hypot(effort[0], effort[1], effort[2]) <= profile.bounds.arm_effort_norm);

      // Every axis off by half a count, one way or the other.
      AxisVector off{};
      for (unsigned k = 0; k < kAxisCount; ++k) off[k] = random(0, 1) < 0.5 ? -0.5 : 0.5;
      for (unsigned k = 0; k < kAxisCount; ++k) off[k] *= profile.quantum[k];
      const Twistd wrong = profile.kinematics.twist_of(q, off);
      for (int k = 0; k < 3; ++k) {
        REQUIRE(std::abs(wrong.linear[k]) <= 0.5 * p.position_quantum_m);
        REQUIRE(std::abs(wrong.angular[k]) <= 0.5 * p.rotation_quantum_rad);
      }
    }
  }
}

TEST_CASE("the bounds of a workspace are not far from what its worst pose needs") {
  // The virtuose's arm at its full length, 0.675 m from the column: the yaw carries 35 N there and 3 N m beside.
  const DeviceProfile& profile = *find_profile("virtuose6d");
  const double yaw_Nm = 35.0 * 0.675 + 3.0;
  CHECK(profile.bounds.effort[0] >= yaw_Nm);
  CHECK(profile.bounds.effort[0] <= 1.1 * yaw_Nm);
  CHECK(profile.bounds.effort[1] == Approx(35.0 * 0.45 * kSpreadMargin));
  CHECK(profile.bounds.rate[0] >= 1.0 / 0.225);
  CHECK(profile.bounds.rate[0] <= 1.1 / 0.225);
}
