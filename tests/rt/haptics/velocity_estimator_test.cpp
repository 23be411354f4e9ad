#include "rt/haptics/velocity_estimator.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <random>

using namespace tactus;
using namespace tactus::haptics;

namespace {

constexpr double kT = 1e-3, kQuantum = 1e-5;

double quantised(double x) { return kQuantum * std::floor(x / kQuantum + 0.5); }

}  // namespace

TEST_CASE("constant velocity on a quantised scale is found within one quantum over the whole window") {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> u(-1, 1);
  for (const std::uint32_t window : {1u, 4u, 8u, 16u}) {
    for (int run = 0; run < 200; ++run) {
      VelocityEstimator estimator{};
      estimator.config.window = window;
      estimator.config.stiction_s = 1e9;  // not what is tested here
      const Vec3d v{u(random), 0.05 * u(random), 0.002 * u(random)}, x0{u(random), u(random), u(random)};
      for (int k = 0; k < 60; ++k) {
        const Vec3d x = x0 + v * (kT * k);
        const Twistd t = estimator.update({{quantised(x.x), quantised(x.y), quantised(x.z)}, {}});
        if (k < 20) continue;
        for (int axis = 0; axis < 3; ++axis) {
          REQUIRE(std::abs(t.linear[axis] - v[axis]) <= kQuantum / (window * kT) * (1 + 1e-6));
        }
      }
    }
  }
}

TEST_CASE("a step of velocity of more than two quanta a tick shows in the next tick") {
  for (const double quanta : {3.0, 20.0}) {
    VelocityEstimator estimator{};
    double x = 0;
    for (int k = 0; k < 50; ++k) estimator.update({{x, 0, 0}, {}});
    for (int k = 0; k < 5; ++k) {
      x += quanta * kQuantum;
      CHECK(estimator.update({{x, 0, 0}, {}}).linear.x == Approx(quanta * kQuantum / kT));
    }
  }
}

TEST_CASE("the axes do not disturb each other") {
  VelocityEstimator estimator{};
  std::mt19937_64 random(2);
  for (int k = 0; k < 60; ++k) {
    const double wild = 1e-3 * static_cast<double>(random() % 100);
    const Twistd t = estimator.update({{wild, quantised(0.0305 * kT * k), 0}, {}});
    if (k > 20) CHECK(t.linear.y == Approx(0.0305).margin(kQuantum / (8 * kT)));
  }
}

TEST_CASE("an axis that has not moved half a quantum for 20 ms is at rest, exactly, and wakes at once") {
  VelocityEstimator estimator{};
  double x = 0;
  for (int k = 0; k < 10; ++k) {
    x += 0.05 * kT;
    estimator.update({{x, 0, 0}, {}});
  }
  for (int k = 1; k <= 40; ++k) {
    x += 0.01 * kQuantum;  // creeps: below what the device can tell
    const double v = estimator.update({{x, 0, 0}, {}}).linear.x;
    if (k == 15) CHECK(v > 0);
    if (k > 20) CHECK(v == 0.0);
  }
  CHECK(estimator.update({{x + kQuantum, 0, 0}, {}}).linear.x > 0);
}

TEST_CASE("a turn about any axis is found, whichever sign its quaternions have") {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> u(-1, 1);
  for (int run = 0; run < 200; ++run) {
    VelocityEstimator estimator{};
    estimator.config.rotation_quantum_rad = 1e-12;  // an exact device: no stiction band
    const Vec3d omega{10 * u(random), 10 * u(random), 10 * u(random)};
    Quatd q = normalized(Quatd{u(random), u(random), u(random), u(random)});
    Twistd t;
    for (int k = 0; k < 30; ++k) {
      const double sign = random() % 2 ? 1 : -1;
      t = estimator.update({{}, {sign * q.w, sign * q.x, sign * q.y, sign * q.z}});
      q = normalized(quat_from_rotation_vector(omega * kT) * q);
    }
    CHECK(norm(t.angular - omega) < 1e-6 * norm(omega));
    CHECK(t.linear == Vec3d{});
  }
}

TEST_CASE("the first pose and a reset start at rest, wherever the tool is") {
  VelocityEstimator estimator{};
  CHECK(estimator.update({{0.1, 0.2, 0.3}, {0, 1, 0, 0}}) == Twistd{});
  estimator.update({{0.11, 0.2, 0.3}, {0, 1, 0, 0}});
  estimator.reset();
  CHECK(estimator.update({{-0.1, 0, 0}, {}}) == Twistd{});
}

TEST_CASE("the window grows with the root of the rate from 8 at 1 kHz: less delay and more noise, both by the root") {
  for (double rate_Hz = 100; rate_Hz <= 10'000; rate_Hz += 100) {
    CAPTURE(rate_Hz);
    const double window = VelocityEstimator::Config::of({}, 1 / rate_Hz).window;
    REQUIRE(window <= kMaxVelocityWindow);
    if (window == kMaxVelocityWindow && rate_Hz > 4000) continue;
    // Delay N T, noise quantum / (N T), relative to 8 ms and to a quantum in 8 ms: within the rounding of N.
    const double delay = window / rate_Hz / 8e-3, rounding = 0.5 / rate_Hz / 8e-3;
    REQUIRE(delay == Approx(std::sqrt(1000 / rate_Hz)).margin(1.001 * rounding));
  }
  CHECK(VelocityEstimator::Config::of({}, 1e-4).window == kMaxVelocityWindow);
}

TEST_CASE("a restored state goes on with the same bits") {
  VelocityEstimator a{};
  std::mt19937_64 random(4);
  for (int k = 0; k < 37; ++k) a.update({{1e-5 * static_cast<double>(random() % 50), 0, 0}, {}});
  VelocityEstimator b{};
  b.state = a.state;
  for (int k = 0; k < 37; ++k) {
    const Posed pose{{1e-5 * static_cast<double>(random() % 50), 0, 0}, {}};
    CHECK(a.update(pose) == b.update(pose));
  }
}
