// Spheres and capsules among themselves and on a plane: configurations with known points.
#include <catch2/catch.hpp>

#include "tests/rt/physics/collision/collide_support.h"

using namespace tactus;
using namespace tactus::physics;
using namespace tactus::physics::support;

namespace {

constexpr double kPi = 3.14159265358979323846;
const Quatd kAlongX = turn({0, 1, 0}, kPi / 2);  // takes body z to world x

}  // namespace

TEST_CASE("Two spheres touch midway between their surfaces") {
  const auto a = Shape::sphere(0.1), b = Shape::sphere(0.2);
  const auto m = touch(a, {{1, 2, 3}, {}}, b, {{1, 2, 3.31}, {}}, 0.02);
  REQUIRE(m.count == 1);
  require_vec(m.normal, {0, 0, 1});
  REQUIRE(m.points[0].separation == Approx(0.01).margin(1e-12));
  require_vec(m.points[0].from_a, {0, 0, 0.105});
  require_vec(m.points[0].from_b, {0, 0, -0.205});
  REQUIRE(touch(a, {}, b, {{0, 0, 0.3201}, {}}, 0.02).count == 0);
}

TEST_CASE("Spheres with one centre are pushed along z by the whole of both radii") {
  const auto m = touch(Shape::sphere(0.1), {}, Shape::sphere(0.2), {}, 0.0);
  REQUIRE(m.count == 1);
  require_vec(m.normal, {0, 0, 1});
  REQUIRE(m.points[0].separation == Approx(-0.3));
}

TEST_CASE("A sphere touches a capsule on its side and on its cap") {
  const auto sphere = Shape::sphere(0.05), capsule = Shape::capsule(0.1, 0.3);
  const auto side = touch(sphere, {{0.16, 0, 0.2}, {}}, capsule, {}, 0.02);
  REQUIRE(side.count == 1);
  require_vec(side.normal, {-1, 0, 0});
  REQUIRE(side.points[0].separation == Approx(0.01).margin(1e-12));
  require_vec(side.points[0].from_b, {0.105, 0, 0.2});
  const Vec3d diagonal = Vec3d{1, 0, 1} * (1 / std::sqrt(2.0));
  const auto cap = touch(sphere, {Vec3d{0, 0, 0.3} + diagonal * 0.14, {}}, capsule, {}, 0.02);
  require_vec(cap.normal, -diagonal);
  REQUIRE(cap.points[0].separation == Approx(-0.01).margin(1e-12));
}

TEST_CASE("A sphere centred on a capsule's axis is pushed square to the axis") {
  const auto m = touch(Shape::sphere(0.05), {}, Shape::capsule(0.1, 0.3), {}, 0.0);
  REQUIRE(m.count == 1);
  REQUIRE(m.normal.z == Approx(0.0).margin(1e-12));
  REQUIRE(m.points[0].separation == Approx(-0.15));
}

TEST_CASE("Parallel capsules rest on the two ends of their common stretch") {
  const auto a = Shape::capsule(0.02, 0.1), b = Shape::capsule(0.03, 0.1);
  // B lies along A, shifted by 0.05: they share [-0.05, 0.1].
  const auto m = touch(a, {{0, 0, 0}, kAlongX}, b, {{0.05, 0, 0.049}, kAlongX}, 0.005);
  REQUIRE(m.count == 2);
  require_vec(m.normal, {0, 0, 1});
  for (const double x : {-0.05, 0.1}) {
    const auto& p = point_near(m, {x, 0, 0.02}, &ManifoldPoint::from_a);
    REQUIRE(p.separation == Approx(-0.001).margin(1e-12));
    require_vec(p.from_a, {x, 0, 0.0195});
  }
}

TEST_CASE("Capsules that run in opposite directions rest on two points as well") {
  const auto a = Shape::capsule(0.02, 0.1);
  const auto m = touch(a, {{0, 0, 0}, kAlongX}, a, {{0, 0, 0.04}, turn({0, 1, 0}, -kPi / 2)}, 0.005);
  REQUIRE(m.count == 2);
}

TEST_CASE("Crossing capsules touch in one point, at any angle that shows") {
  const auto a = Shape::capsule(0.02, 0.1);
  for (const double angle : {0.02, 0.1, 0.5, kPi / 2}) {
    const auto m = touch(a, {{0, 0, 0}, kAlongX}, a, {{0, 0, 0.041}, turn({0, 0, 1}, angle) * kAlongX}, 0.005);
    INFO("angle " << angle);
    REQUIRE(m.count == 1);
    REQUIRE(m.points[0].separation == Approx(0.001).margin(1e-12));
    require_vec(m.points[0].from_a, {0, 0, 0.0205});
  }
}

TEST_CASE("A capsule tipped onto another reports both ends, each with its own gap") {
  const auto a = Shape::capsule(0.02, 0.1), b = Shape::capsule(0.02, 0.05);
  const double tilt = 0.01;  // rad: one end of B 0.5 mm lower than its middle, the other as much higher
  const Quatd q = turn({0, 1, 0}, tilt) * kAlongX;
  const auto m = touch(a, {{0, 0, 0}, kAlongX}, b, {{0, 0, 0.041}, q}, 0.005);
  REQUIRE(m.count == 2);
  const double drop = 0.05 * std::sin(tilt);
  REQUIRE(least_separation(m) == Approx(0.001 - drop).margin(1e-12));
  REQUIRE(m.points[0].separation + m.points[1].separation == Approx(0.002).margin(1e-7));
}

TEST_CASE("Where two capsules' ends pass by a hair the nearer point carries the distance of the ends") {
  // B's low end is 0.4 mm beyond A's end; B rises back over A by 1 in 50, so the closest points are the two ends.
  const auto a = Shape::capsule(0.02, 0.1), b = Shape::capsule(0.02, 0.05);
  const double rise = std::atan(0.02), past = 4e-4, above = 0.041;
  const Vec3d low_end{0.1 + past, 0, above}, direction{-std::cos(rise), 0, std::sin(rise)};
  const auto m = touch(a, {{}, kAlongX}, b, {low_end + direction * 0.05, turn({0, 1, 0}, rise - kPi / 2)}, 0.005);
  REQUIRE(m.count == 2);
  REQUIRE(least_separation(m) == Approx(std::sqrt(past * past + above * above) - 0.04).margin(1e-12));
}

TEST_CASE("Capsules end to end touch in one point on the caps") {
  const auto a = Shape::capsule(0.02, 0.1);
  const auto m = touch(a, {}, a, {{0, 0, 0.241}, {}}, 0.005);
  REQUIRE(m.count == 1);
  require_vec(m.normal, {0, 0, 1});
  REQUIRE(m.points[0].separation == Approx(0.001).margin(1e-12));
}

TEST_CASE("Capsules whose axes cross are pushed along the common perpendicular") {
  const auto a = Shape::capsule(0.02, 0.1);
  const auto m = touch(a, {}, a, {{0, 0, 0}, kAlongX}, 0.0);
  REQUIRE(m.count == 1);
  REQUIRE(std::abs(m.normal.y) == Approx(1.0));
  REQUIRE(m.points[0].separation == Approx(-0.04));
}

TEST_CASE("A sphere on a tilted plane touches under its centre along the plane's normal") {
  const Quatd tilt = turn({1, 0, 0}, 0.5);
  const Vec3d up = rotate(tilt, Vec3d{0, 0, 1}), on_plane{3, -2, 1};
  const Vec3d aside = rotate(tilt, Vec3d{0.7, 0.4, 0});
  const auto m =
      touch(Shape::sphere(0.1), {on_plane + aside + up * 0.102, {}}, Shape::plane(), {on_plane, tilt}, 0.005);
  REQUIRE(m.count == 1);
  require_vec(m.normal, -up);
  REQUIRE(m.points[0].separation == Approx(0.002).margin(1e-12));
  require_vec(m.points[0].from_b, aside + up * 0.001);
}

TEST_CASE("A plane may come first: the normal is the plane's own") {
  const auto m = touch(Shape::plane(), {}, Shape::sphere(0.1), {{0, 0, 0.1}, {}}, 0.001);
  REQUIRE(m.count == 1);
  require_vec(m.normal, {0, 0, 1});
  require_vec(m.points[0].from_b, {0, 0, -0.1});
}

TEST_CASE("A lying capsule rests on the plane on two points and a standing one on one") {
  const auto capsule = Shape::capsule(0.02, 0.1);
  const auto lying = touch(capsule, {{0, 0, 0.019}, kAlongX}, Shape::plane(), {}, 0.002);
  REQUIRE(lying.count == 2);
  require_vec(lying.normal, {0, 0, -1});
  for (const double x : {-0.1, 0.1}) {
    const auto& p = point_near(lying, {x, 0, -0.02}, &ManifoldPoint::from_a);
    require_vec(p.from_a, {x, 0, -0.0195});
    REQUIRE(p.separation == Approx(-0.001).margin(1e-12));
  }
  const auto standing = touch(capsule, {{0, 0, 0.121}, {}}, Shape::plane(), {}, 0.002);
  REQUIRE(standing.count == 1);
  REQUIRE(standing.points[0].separation == Approx(0.001).margin(1e-12));
}

TEST_CASE("Two planes never touch") {
  REQUIRE(touch(Shape::plane(), {}, Shape::plane(), {{0, 0, -1}, {}}, 0.01).count == 0);
}
