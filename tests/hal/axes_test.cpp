#include "hal/axes.h"

#include <catch2/catch.hpp>
#include <random>

using namespace tactus;
using namespace tactus::hal;

namespace {

constexpr double kPi = 3.14159265358979323846;
const CartesianStage kStage;

struct Random {
  std::mt19937_64 engine{7};
  double in(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine); }
  Vec3d vector(double size) { return {in(-size, size), in(-size, size), in(-size, size)}; }
  AxisVector coordinates() {
    return {in(-1, 1), in(-1, 1), in(-1, 1), in(-kPi, kPi), in(-kPitchLimit_rad, kPitchLimit_rad), in(-kPi, kPi)};
  }
  AxisVector rates() { return {in(-1, 1), in(-1, 1), in(-1, 1), in(-9, 9), in(-9, 9), in(-9, 9)}; }
};

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

}  // namespace

TEST_CASE("axis efforts do the work of the wrench in every configuration") {
  Random random;
  for (int i = 0; i < 20000; ++i) {
    const AxisVector q = random.coordinates(), rate = random.rates();
    const Wrenchd wrench{random.vector(35), random.vector(3)};
    const Twistd twist = kStage.twist_of(q, rate);
    const double power = dot(wrench.force, twist.linear) + dot(wrench.torque, twist.angular);
    REQUIRE(product(kStage.efforts_of(q, wrench), rate) == Approx(power).margin(1e-10));
  }
}

TEST_CASE("the Jacobian is the derivative of the pose") {
  Random random;
  const double dt = 1e-6;
  for (int i = 0; i < 2000; ++i) {
    const AxisVector q = random.coordinates(), rate = random.rates();
    AxisVector before = q, after = q;
    for (unsigned k = 0; k < kAxisCount; ++k) before[k] -= 0.5 * dt * rate[k], after[k] += 0.5 * dt * rate[k];
    const Posed a = kStage.pose_of(before), b = kStage.pose_of(after);
    const Twistd twist = kStage.twist_of(q, rate);
    check_close((b.position - a.position) * (1.0 / dt), twist.linear, 1e-8);
    check_close(small_rotation_vector(b.rotation * conjugate(a.rotation)) * (1.0 / dt), twist.angular, 1e-7);
  }
}

TEST_CASE("rates and wrenches come back from twists and efforts up to the pitch limit") {
  Random random;
  for (int i = 0; i < 20000; ++i) {
    AxisVector q = random.coordinates();
    if (i % 10 == 0) q[4] = i % 20 == 0 ? kPitchLimit_rad : -kPitchLimit_rad;
    const AxisVector rate = random.rates(), back = kStage.rates_of(q, kStage.twist_of(q, rate));
    for (unsigned k = 0; k < kAxisCount; ++k) REQUIRE(back[k] == Approx(rate[k]).margin(1e-12));
    const Wrenchd wrench{random.vector(35), random.vector(3)},
        again = kStage.wrench_of(q, kStage.efforts_of(q, wrench));
    check_close(again.force, wrench.force, 1e-12);
    check_close(again.torque, wrench.torque, 1e-12);
  }
}

TEST_CASE("yaw turns x to y, pitch x to -z, roll y to z") {
  const Vec3d x{1, 0, 0}, y{0, 1, 0};
  const auto turned = [](double yaw, double pitch, double roll, const Vec3d& v) {
    return rotate(kStage.pose_of({0, 0, 0, yaw, pitch, roll}).rotation, v);
  };
  check_close(turned(kPi / 2, 0, 0, x), {0, 1, 0}, 1e-15);
  check_close(turned(0, kPi / 2, 0, x), {0, 0, -1}, 1e-15);
  check_close(turned(0, 0, kPi / 2, y), {0, 0, 1}, 1e-15);
  check_close(turned(kPi / 2, 0, kPi / 2, y), {0, 0, 1}, 1e-15);  // roll first, then yaw
  CHECK(kStage.pose_of({1, 2, 3, 0, 0, 0}).position == Vec3d{1, 2, 3});
}

TEST_CASE("the singular wrist gives finite answers") {
  for (const double pitch : {kPi / 2, -kPi / 2, 1.5, 2e5}) {
    const AxisVector q{0, 0, 0, 0.3, pitch, 0.2};
    const AxisVector rates = kStage.rates_of(q, {{}, {10, 10, 10}});
    for (const double rate : rates) CHECK(std::abs(rate) < 10.0 * 3 / kCosPitchLimit + 10);
    const Wrenchd wrench = kStage.wrench_of(q, {0, 0, 0, 3, 3, 3});
    CHECK(norm(wrench.torque) < 6.0 / kCosPitchLimit + 6);
  }
}
