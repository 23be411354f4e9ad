// Sphere and capsule against a box: configurations with known points.
#include <catch2/catch.hpp>

#include "tests/rt/physics/collision/collide_support.h"

using namespace tactus;
using namespace tactus::physics;
using namespace tactus::physics::support;

namespace {

constexpr double kPi = 3.14159265358979323846;
const Shape kBox = Shape::box({0.1, 0.2, 0.3});
const Shape kCapsule = Shape::capsule(0.02, 0.05);
const Quatd kAlongX = turn({0, 1, 0}, kPi / 2), kAlongY = turn({1, 0, 0}, -kPi / 2);

}  // namespace

TEST_CASE("A sphere touches a box on a face, an edge and a corner") {
  const auto sphere = Shape::sphere(0.05);
  const Vec3d directions[] = {{0, 0, 1}, Vec3d{0, 1, 1} * (1 / std::sqrt(2.0)), Vec3d{-1, 1, 1} * (1 / std::sqrt(3.0))};
  const Vec3d touched[] = {{0.03, 0.05, 0.3}, {0.03, 0.2, 0.3}, {-0.1, 0.2, 0.3}};
  for (int k = 0; k < 3; ++k) {
    const auto m = touch(sphere, {touched[k] + directions[k] * 0.051, {}}, kBox, {}, 0.002);
    REQUIRE(m.count == 1);
    require_vec(m.normal, -directions[k]);
    REQUIRE(m.points[0].separation == Approx(0.001).margin(1e-12));
    require_vec(m.points[0].from_b, touched[k] + directions[k] * 0.0005);
  }
}

TEST_CASE("A sphere whose centre is in a box leaves through the nearest face") {
  const auto sphere = Shape::sphere(0.05);
  const auto m = touch(sphere, {{0.01, -0.17, 0.05}, {}}, kBox, {}, 0.0);
  REQUIRE(m.count == 1);
  require_vec(m.normal, {0, 1, 0});  // from the sphere to the box: the sphere leaves along -y
  REQUIRE(m.points[0].separation == Approx(-0.08).margin(1e-12));
  const auto centred = touch(sphere, {}, Shape::box({0.1, 0.1, 0.1}), {}, 0.0);
  require_vec(centred.normal, {-1, 0, 0});  // a tie: the lowest axis, towards +
}

TEST_CASE("The gap of a sphere changes smoothly as its centre enters a box") {
  const auto sphere = Shape::sphere(0.05);
  for (const double depth : {-1e-6, -1e-13, 0.0, 1e-13, 1e-6}) {
    const auto m = touch(sphere, {{0.03, 0.05, 0.3 - depth}, {}}, kBox, {}, 0.0);
    REQUIRE(m.count == 1);
    require_vec(m.normal, {0, 0, -1});
    REQUIRE(m.points[0].separation == Approx(-0.05 - depth).margin(1e-12));
  }
}

TEST_CASE("A capsule lying on a face rests on two points") {
  const auto m = touch(kCapsule, {{0.01, 0.02, 0.319}, kAlongX}, kBox, {}, 0.002);
  REQUIRE(m.count == 2);
  require_vec(m.normal, {0, 0, -1});
  for (const double x : {-0.04, 0.06}) {
    const auto& p = point_near(m, {x, 0.02, 0.3}, &ManifoldPoint::from_b);
    REQUIRE(p.separation == Approx(-0.001).margin(1e-12));
    require_vec(p.from_b, {x, 0.02, 0.2995});
  }
}

TEST_CASE("A capsule that hangs over a face rests at the edge, and goes on so when it tips by a hair") {
  for (const double tilt : {-1e-4, -1e-9, 0.0, 1e-9, 1e-4}) {
    INFO("tilt " << tilt);
    const auto m = touch(kCapsule, {{0.08, 0.02, 0.32}, turn({0, 1, 0}, tilt) * kAlongX}, kBox, {}, 0.002);
    REQUIRE(m.count == 2);
    for (const double x : {0.03, 0.1}) {
      const auto& p = point_near(m, {x, 0.02, 0.3}, &ManifoldPoint::from_b);
      REQUIRE(norm(p.from_b - Vec3d{x, 0.02, 0.3}) < 2e-5);
      REQUIRE(std::abs(p.separation) < 2e-5);
    }
  }
}

TEST_CASE("A capsule along an edge, outside of both faces, rests on two points") {
  const Vec3d diagonal = Vec3d{1, 0, 1} * (1 / std::sqrt(2.0));
  const auto m = touch(kCapsule, {Vec3d{0.1, 0.18, 0.3} + diagonal * 0.021, kAlongY}, kBox, {}, 0.002);
  REQUIRE(m.count == 2);
  require_vec(m.normal, -diagonal);
  for (const double y : {0.13, 0.2}) {  // the box ends at y = 0.2
    const auto& p = point_near(m, {0.1, y, 0.3}, &ManifoldPoint::from_b);
    require_vec(p.from_b, Vec3d{0.1, y, 0.3} + diagonal * 0.0005);
    REQUIRE(p.separation == Approx(0.001).margin(1e-12));
  }
}

TEST_CASE("A capsule across an edge, on a corner or standing on a face touches in one point") {
  const Vec3d diagonal = Vec3d{1, 0, 1} * (1 / std::sqrt(2.0));
  const auto across =
      touch(kCapsule, {Vec3d{0.1, 0.03, 0.3} + diagonal * 0.021, turn({0, 1, 0}, kPi * 0.75)}, kBox, {}, 0.002);
  REQUIRE(across.count == 1);
  require_vec(across.normal, -diagonal);
  REQUIRE(across.points[0].separation == Approx(0.001).margin(1e-12));
  require_vec(across.points[0].from_b, Vec3d{0.1, 0.03, 0.3} + diagonal * 0.0005);

  const auto standing = touch(kCapsule, {{0.02, 0.03, 0.371}, {}}, kBox, {}, 0.002);
  REQUIRE(standing.count == 1);
  require_vec(standing.normal, {0, 0, -1});
  REQUIRE(standing.points[0].separation == Approx(0.001).margin(1e-12));

  const auto corner =
      touch(kCapsule, {Vec3d{0.1, 0.2, 0.3} + Vec3d{1, 1, 0} * (0.021 / std::sqrt(2.0)) + Vec3d{0, 0, 0.05}, {}}, kBox,
            {}, 0.002);
  REQUIRE(corner.count == 1);
  REQUIRE(corner.points[0].separation == Approx(0.001).margin(1e-12));
}

TEST_CASE("A capsule whose axis is in a box is pushed out along the face that needs least") {
  const auto m = touch(kCapsule, {{0.01, 0.02, 0.29}, kAlongX}, kBox, {}, 0.0);
  REQUIRE(m.count == 2);
  require_vec(m.normal, {0, 0, -1});
  for (std::uint32_t i = 0; i < 2; ++i) REQUIRE(m.points[i].separation == Approx(-0.03).margin(1e-12));
}

TEST_CASE("A long capsule stuck through an edge of a box is pushed out square to both") {
  // In the xz plane, across the upper right edge, 5 mm inside of it: the edge direction is x + z.
  const Vec3d diagonal = Vec3d{1, 0, 1} * (1 / std::sqrt(2.0));
  const auto rod = Shape::capsule(0.01, 0.5);
  const auto m = touch(rod, {Vec3d{0.1, 0.03, 0.3} - diagonal * 0.005, turn({0, 1, 0}, kPi * 0.75)}, kBox, {}, 0.0);
  REQUIRE(m.count == 1);
  require_vec(m.normal, -diagonal);
  REQUIRE(m.points[0].separation == Approx(-0.015).margin(1e-12));
  REQUIRE(norm(m.points[0].from_b - (Vec3d{0.1, 0.03, 0.3} - diagonal * 0.0075)) < 1e-9);
}
