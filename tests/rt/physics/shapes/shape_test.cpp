#include "rt/physics/shapes/shape.h"

#include <catch2/catch.hpp>
#include <limits>

#include "tests/rt/physics/collision/collide_support.h"

using namespace tactus;
using namespace tactus::physics;
using namespace tactus::physics::support;

namespace {

constexpr double kPi = 3.14159265358979323846;

// Inertia about the axes by summing thin discs (density 1) across body z; `radius_at` in [-reach, reach].
template <class Radius>
Vec3d inertia_by_discs(double reach, Radius radius_at) {
  constexpr int n = 20000;
  Vec3d sum;
  for (int k = 0; k < n; ++k) {
    const double dz = 2 * reach / n, z = -reach + (k + 0.5) * dz, r2 = radius_at(z) * radius_at(z);
    const double mass = kPi * r2 * dz;
    sum += Vec3d{mass * (r2 / 4 + z * z), mass * (r2 / 4 + z * z), mass * r2 / 2};
  }
  return sum;
}

}  // namespace

TEST_CASE("A sphere's volume and inertia are the textbook's") {
  const auto s = Shape::sphere(0.2);
  REQUIRE(volume_of(s) == Approx(4.0 / 3.0 * kPi * 0.008));
  const Vec3d i = inertia_of(s, 3.0);
  REQUIRE(i.x == Approx(0.4 * 3.0 * 0.04));
  REQUIRE(i == Vec3d{i.x, i.x, i.x});
  REQUIRE(bounding_radius(s) == 0.2);
}

TEST_CASE("A box's volume and inertia are the textbook's") {
  const auto s = Shape::box({0.1, 0.2, 0.3});
  REQUIRE(volume_of(s) == Approx(0.2 * 0.4 * 0.6));
  const Vec3d i = inertia_of(s, 2.0);
  REQUIRE(i.x == Approx(2.0 / 12.0 * (0.4 * 0.4 + 0.6 * 0.6)));
  REQUIRE(i.y == Approx(2.0 / 12.0 * (0.2 * 0.2 + 0.6 * 0.6)));
  REQUIRE(i.z == Approx(2.0 / 12.0 * (0.2 * 0.2 + 0.4 * 0.4)));
  REQUIRE(bounding_radius(s) == Approx(std::sqrt(0.01 + 0.04 + 0.09)));
}

TEST_CASE("A capsule's inertia is the sum over its discs") {
  const double r = 0.07, l = 0.11;
  const auto s = Shape::capsule(r, l);
  const Vec3d discs = inertia_by_discs(r + l, [&](double z) {
    const double beyond = std::max(0.0, std::abs(z) - l);
    return std::sqrt(std::max(0.0, r * r - beyond * beyond));
  });
  const Vec3d i = inertia_of(s, volume_of(s));  // density 1
  REQUIRE(i.x == Approx(discs.x).epsilon(1e-6));
  REQUIRE(i.y == Approx(discs.y).epsilon(1e-6));
  REQUIRE(i.z == Approx(discs.z).epsilon(1e-6));
  REQUIRE(bounding_radius(s) == Approx(r + l));
}

TEST_CASE("A capsule is a ball without length and a rod without radius") {
  const Vec3d ball = inertia_of(Shape::capsule(0.1, 0.0), 2.0), sphere = inertia_of(Shape::sphere(0.1), 2.0);
  REQUIRE(ball.x == Approx(sphere.x));
  REQUIRE(ball.z == Approx(sphere.z));
  const Vec3d rod = inertia_of(Shape::capsule(0.0, 0.3), 2.0);
  REQUIRE(rod.x == Approx(2.0 * 0.6 * 0.6 / 12.0));
  REQUIRE(rod.z == 0.0);
  REQUIRE(inertia_of(Shape::capsule(0.0, 0.0), 2.0) == Vec3d{});
}

TEST_CASE("A plane has no volume and no inertia, and its bounds hold everything") {
  const auto s = Shape::plane();
  REQUIRE(volume_of(s) == 0.0);
  REQUIRE(inertia_of(s, 1.0) == Vec3d{});
  REQUIRE(bounding_radius(s) == std::numeric_limits<double>::infinity());
  Random random(1);
  for (int n = 0; n < 100; ++n) {
    const Aabb ball = bounds_of(Shape::sphere(0.1), random.pose(1e6), 0.0);
    REQUIRE(bounds_of(s, random.pose(10.0), 0.0).overlaps(ball));
  }
}

TEST_CASE("Bounds touch the shape on all six sides and the margin is added") {
  Random random(2);
  for (int n = 0; n < 500; ++n) {
    const ShapeKind kind = std::array{ShapeKind::kSphere, ShapeKind::kCapsule, ShapeKind::kBox}[random.below(3)];
    const Shape shape = random_shape(random, kind);
    const Posed pose = random.pose(2.0);
    const Aabb box = bounds_of(shape, pose, 0.01);
    for (int axis = 0; axis < 3; ++axis) {
      // The highest point along the axis: of the corners, or of the axis' ends plus the radius.
      double high = -1e9, low = 1e9;
      for (unsigned k = 0; k < 8; ++k) {
        const Vec3d p = kind == ShapeKind::kBox ? PosedBox{shape.half_extents, pose}.corner(k)
                                                : pose * Vec3d{0, 0, k & 1 ? shape.half_length : -shape.half_length};
        high = std::max(high, p[axis] + shape.radius);
        low = std::min(low, p[axis] - shape.radius);
      }
      REQUIRE(box.upper[axis] == Approx(high + 0.01).margin(1e-12));
      REQUIRE(box.lower[axis] == Approx(low - 0.01).margin(1e-12));
    }
  }
}

TEST_CASE("Bounds overlap when they share a point on every axis") {
  const Aabb a{{0, 0, 0}, {1, 1, 1}};
  REQUIRE(a.overlaps({{1, 1, 1}, {2, 2, 2}}));
  for (int axis = 0; axis < 3; ++axis) {
    Aabb above{{0, 0, 0}, {1, 1, 1}}, below = above;
    above.lower[axis] = 1.001;
    above.upper[axis] = 2;
    below.lower[axis] = -1;
    below.upper[axis] = -0.001;
    REQUIRE_FALSE(a.overlaps(above));
    REQUIRE_FALSE(a.overlaps(below));
  }
}
