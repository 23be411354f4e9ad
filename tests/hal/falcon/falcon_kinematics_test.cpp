// The Falcon's kinematics and packets: points and vectors of its documents, finite differences, power in and out.
#include <catch2/catch.hpp>
#include <random>
#include <string>

#include "hal/falcon/delta_arm.h"
#include "hal/falcon/falcon_packet.h"

using namespace tactus;
using namespace tactus::hal;

namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;

Vec3d random_in_workspace(std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (;;) {
    const Vec3d at{uniform(random), uniform(random), uniform(random)};
    if (norm(at) <= 1) return at * DeltaArm::kWorkspaceRadius_m;
  }
}

}  // namespace

TEST_CASE("falcon: the legs' angles at known points") {
  struct Point {
    Vec3d at;
    double degrees[3];
  };
  const Point points[] = {{{0, 0, 0.150}, {47.243, 47.243, 47.243}},     {{0, 0, 0.120}, {23.918, 23.918, 23.918}},
                          {{0, 0, 0.100}, {8.008, 8.008, 8.008}},        {{0, 0, 0.080}, {-11.8, -11.8, -11.8}},
                          {{0, 0, 0.170}, {66.756, 66.756, 66.756}},     {{0.03, 0.02, 0.13}, {31.299, 22.024, 55.131}},
                          {{-0.04, 0.01, 0.11}, {9.561, 48.383, 10.092}}};
  for (const Point& point : points)
    for (unsigned leg = 0; leg < 3; ++leg)
      CHECK(DeltaArm::leg_at(leg, point.at).theta1 / kDegree == Approx(point.degrees[leg]).margin(0.0015));
}

TEST_CASE("falcon: the Jacobian at the maker's centre, and by finite differences all over the reach") {
  const double rows[3][3] = {{2.682, -8.767, 14.641}, {-8.934, 2.060, 14.641}, {6.251, 6.706, 14.641}};
  for (unsigned leg = 0; leg < 3; ++leg) {
    const Vec3d gradient = DeltaArm::leg_at(leg, {0, 0, 0.150}).gradient;
    CHECK(norm(gradient - Vec3d{rows[leg][0], rows[leg][1], rows[leg][2]}) < 0.01);
  }
  std::mt19937 random(1);
  const DeltaArm arm;
  constexpr double h = 1e-6;
  for (int i = 0; i < 2000; ++i) {
    const Vec3d at = random_in_workspace(random);
    const AxisVector q = DeltaArm::axes_of(at);
    for (const Vec3d& direction : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}) {
      const AxisVector ahead = DeltaArm::axes_of(at + direction * h), behind = DeltaArm::axes_of(at - direction * h);
      const AxisVector rate = arm.rates_of(q, {direction, {}});
      for (unsigned axis = 0; axis < 3; ++axis)
        REQUIRE(rate[axis] == Approx((ahead[axis] - behind[axis]) / (2 * h)).margin(1e-4));
      REQUIRE(norm(arm.twist_of(q, rate).linear - direction) < 1e-9);
    }
  }
}

TEST_CASE("falcon: forward is the inverse's inverse, and power in is power out") {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const DeltaArm arm;
  for (int i = 0; i < 5000; ++i) {
    const Vec3d at = random_in_workspace(random);
    const AxisVector q = DeltaArm::axes_of(at);
    Vec3d found{0, 0, 0.125};
    REQUIRE(DeltaArm::solve(q, found));
    REQUIRE(norm(arm.pose_of(q).position - at) < 1e-9);
    const Vec3d force{uniform(random), uniform(random), uniform(random)};
    const Vec3d velocity{uniform(random), uniform(random), uniform(random)};
    const AxisVector effort = arm.efforts_of(q, {force, {}}), rate = arm.rates_of(q, {velocity, {}});
    const double power = effort[0] * rate[0] + effort[1] * rate[1] + effort[2] * rate[2];
    REQUIRE(power == Approx(dot(force, velocity)).margin(1e-9));
    REQUIRE(norm(arm.wrench_of(q, effort).force - force) < 1e-9);
  }
}

TEST_CASE("falcon: counts that no position has are found out, and nothing is infinite") {
  std::mt19937 random(3);
  std::uniform_int_distribution<int> count(-32768, 32767);
  unsigned refused = 0;
  for (int i = 0; i < 20000; ++i) {
    AxisVector q{};
    for (unsigned axis = 0; axis < 3; ++axis)
      q[axis] = DeltaArm::kZeroCount_rad + count(random) * DeltaArm::kCount_rad - DeltaArm::centre_angle();
    Vec3d found{0, 0, 0.125};
    refused += !DeltaArm::solve(q, found);
    REQUIRE(is_finite(found));
    REQUIRE(is_finite(DeltaArm().wrench_of(q, {1, 1, 1, 0, 0, 0})));
  }
  CHECK(refused > 19000);
}

TEST_CASE("falcon: packets, their vectors and what is none") {
  const auto text = [](const FalconRequest& request) {
    const FalconBytes bytes = encode_falcon(request);
    return std::string(bytes.begin(), bytes.end());
  };
  CHECK(text({{0, 0, 0}, false, false, false, false}) == "<AAAAAAAAAAAAAA>");
  CHECK(text({{0, 0, 0}, true, true, false, false}) == "<AAAAAAAAAAAADA>");
  CHECK(text({{100, -200, 4095}, true, false, true, false}) == "<EGAAIDPPPPPAFA>");
  FalconState state;
  const auto decode = [&](const std::string& packet) {
    return decode_falcon(std::span<const std::uint8_t, 16>(reinterpret_cast<const std::uint8_t*>(packet.data()), 16),
                         state);
  };
  CHECK(decode(std::string("<EGAAIDPPPPPA") + static_cast<char>('A' + 0x75) + "A>"));
  CHECK((state.counts == std::array<std::int16_t, 3>{100, -200, 4095} && state.buttons == 5 && state.homed == 7));
  for (const char* broken : {"<EGAAIDPPPPPAFA<", "xEGAAIDPPPPPAFA>", "<QGAAIDPPPPPAFA>", "<EG@AIDPPPPPAFA>"})
    CHECK_FALSE(decode(broken));
}

TEST_CASE("falcon: packets are found in a stream, whole ones alone") {
  FalconScanner scanner;
  FalconState state;
  unsigned found = 0;
  const std::string stream = "AAA>xx<EGAAIDPPPPPAFA><EGAAIDPPPP><EGAAIDPP<EGAAIDPPPPPAFA>>";
  for (const char c : stream) found += scanner.take(static_cast<std::uint8_t>(c), state);
  CHECK(found == 2);
  CHECK(scanner.broken() == 1);
  CHECK(state.counts[2] == 4095);
}
