// A box on a plane: which corners, and that a thin card keeps its four.
#include <catch2/catch.hpp>
#include <set>

#include "tests/rt/physics/collision/collide_support.h"

using namespace tactus;
using namespace tactus::physics;
using namespace tactus::physics::support;

namespace {

constexpr double kPi = 3.14159265358979323846;

std::set<std::uint32_t> features(const Manifold& m) {
  std::set<std::uint32_t> result;
  for (std::uint32_t i = 0; i < m.count; ++i) result.insert(m.points[i].feature);
  return result;
}

}  // namespace

TEST_CASE("A box flat on a plane rests on its four lower corners") {
  const auto box = Shape::box({0.1, 0.2, 0.3});
  const auto m = touch(box, {{5, 6, 0.299}, {}}, Shape::plane(), {}, 0.002);
  REQUIRE(m.count == 4);
  REQUIRE(m.normal == Vec3d{0, 0, -1});
  for (std::uint32_t i = 0; i < 4; ++i) {
    const auto& p = m.points[i];
    REQUIRE(p.separation == Approx(-0.001).margin(1e-12));
    REQUIRE(std::abs(p.from_a.x) == Approx(0.1));
    REQUIRE(std::abs(p.from_a.y) == Approx(0.2));
    REQUIRE(p.from_a.z == Approx(-0.2995));
    REQUIRE(p.from_b.z == Approx(-0.0005));
  }
  REQUIRE(features(m) == std::set<std::uint32_t>{0, 1, 2, 3});
}

TEST_CASE("Each of the six faces rests on its own corners") {
  const auto box = Shape::box({0.1, 0.2, 0.3});
  const Quatd turns[] = {{},
                         turn({1, 0, 0}, kPi / 2),
                         turn({1, 0, 0}, kPi),
                         turn({1, 0, 0}, -kPi / 2),
                         turn({0, 1, 0}, kPi / 2),
                         turn({0, 1, 0}, -kPi / 2)};
  for (const Quatd& q : turns) {
    const Vec3d down = rotate_inverse(q, Vec3d{0, 0, -1});  // in the box's frame
    const Vec3d size = abs(down);
    const int axis = size.x > 0.5 ? 0 : size.y > 0.5 ? 1 : 2;
    const auto m = touch(box, {{0, 0, box.half_extents[axis] + 0.001}, q}, Shape::plane(), {}, 0.002);
    REQUIRE(m.count == 4);
    REQUIRE(features(m).size() == 4);
    for (const std::uint32_t f : features(m)) REQUIRE(((f >> axis) & 1u) == (down[axis] > 0 ? 1u : 0u));
    REQUIRE(least_separation(m) == Approx(0.001).margin(1e-12));
  }
}

TEST_CASE("A box on an edge rests on two corners and one on a corner on one") {
  const auto box = Shape::box({0.1, 0.1, 0.1});
  const auto edge = touch(box, {{0, 0, 0.1 * std::sqrt(2.0)}, turn({1, 0, 0}, kPi / 4)}, Shape::plane(), {}, 1e-3);
  REQUIRE(edge.count == 2);
  for (std::uint32_t i = 0; i < 2; ++i) REQUIRE(edge.points[i].separation == Approx(0.0).margin(1e-12));
  const Vec3d axis = Vec3d{1, -1, 0} * (1 / std::sqrt(2.0));
  const auto corner =
      touch(box, {{0, 0, 0.1 * std::sqrt(3.0)}, turn(axis, std::acos(1 / std::sqrt(3.0)))}, Shape::plane(), {}, 1e-3);
  REQUIRE(corner.count == 1);
  REQUIRE(corner.points[0].separation == Approx(0.0).margin(1e-12));
  REQUIRE(norm(corner.points[0].from_a - Vec3d{0, 0, -0.1 * std::sqrt(3.0)}) < 1e-9);
}

TEST_CASE("A thin card tipped by a little keeps the corners of its far edge, not those of its upper face") {
  // 0.3 mm thick: the upper corners of the low edge are nearer to the plane than the lower corners of the far edge.
  const auto card = Shape::box({0.05, 0.03, 0.00015});
  const double tilt = 0.02;  // rad: the far edge is 2 mm up
  const auto m = touch(card, {{0, 0, 0.05 * std::sin(tilt) + 0.00015 * std::cos(tilt)}, turn({0, 1, 0}, tilt)},
                       Shape::plane(), {}, 5e-3);
  REQUIRE(m.count == 4);
  REQUIRE(features(m) == std::set<std::uint32_t>{0, 1, 2, 3});
  double highest = 0;
  for (std::uint32_t i = 0; i < 4; ++i) highest = std::max(highest, m.points[i].separation);
  REQUIRE(least_separation(m) == Approx(0.0).margin(1e-12));
  REQUIRE(highest == Approx(0.1 * std::sin(tilt)).margin(1e-12));
}

TEST_CASE("The lowest corner of a box above a plane is always among the points") {
  Random random(3);
  for (int n = 0; n < 2000; ++n) {
    const auto box = random_shape(random, ShapeKind::kBox);
    const Posed plane = random.pose(1.0), above{{random(-1, 1), random(-1, 1), 0}, random.rotation()};
    double lowest = 1e9;
    for (unsigned k = 0; k < 8; ++k) lowest = std::min(lowest, PosedBox{box.half_extents, above}.corner(k).z);
    Posed resting = above;
    resting.position.z = -lowest + 1e-3;
    const auto m = touch(box, plane * resting, Shape::plane(), plane, 2e-3);
    REQUIRE(m.count >= 1);
    REQUIRE(least_separation(m) == Approx(1e-3).margin(1e-9));
  }
}
