// Hulls: closed surfaces, planes, and mass properties against formulas.
#include "rt/physics/shapes/hull.h"

#include <catch2/catch.hpp>

#include "tests/rt/physics/shapes/hull_support.h"

using namespace tactus;
using namespace tactus::physics;
using namespace tactus::physics::support;

namespace {

std::vector<Vec3d> corners(const Vec3d& half, const Posed& pose) {
  std::vector<Vec3d> points;
  for (const Vec3d& v : solid_of(BoxHull(half).view(), pose).vertices) points.push_back(v);
  return points;
}

// R diag(inertia) R^T: does not depend on which principal axis comes first.
SymMat3d inertia_in_given(const TestHull& made) {
  return rotate_diagonal(made.given_from_body.rotation, made.hull.inertia_per_kg);
}

}  // namespace

TEST_CASE("A box anywhere has a box's volume, centre and moments") {
  const Vec3d half{0.1, 0.2, 0.35};
  Random random(11);
  for (int n = 0; n < 50; ++n) {
    const Posed pose = random.pose(3.0);
    TestHull made;
    REQUIRE(make_hull(corners(half, pose), kBoxTopology, made.hull, made.given_from_body) == HullFault::kNone);
    REQUIRE(made.hull.volume == Approx(8 * half.x * half.y * half.z).epsilon(1e-12));
    REQUIRE(norm(made.given_from_body.position - pose.position) < 1e-12);
    const SymMat3d given = inertia_in_given(made);
    const SymMat3d expected = rotate_diagonal(pose.rotation, inertia_of(Shape::box(half), 1.0));
    for (const auto& [a, b] :
         {std::pair(given.xx, expected.xx), std::pair(given.yy, expected.yy), std::pair(given.zz, expected.zz),
          std::pair(given.xy, expected.xy), std::pair(given.xz, expected.xz), std::pair(given.yz, expected.yz)})
      REQUIRE(a == Approx(b).margin(1e-12));
    REQUIRE(made.hull.bounding_radius == Approx(norm(half)).epsilon(1e-12));
    REQUIRE(made.hull.inner_radius == Approx(0.1).epsilon(1e-12));
    REQUIRE(made.hull.least_width == Approx(0.2).epsilon(1e-12));
    REQUIRE(made.hull.flatness < 1e-12);
  }
}

TEST_CASE("A box along the axes, and a cube, keep them") {
  for (const Vec3d& half : {Vec3d{0.1, 0.2, 0.35}, Vec3d{0.1, 0.1, 0.1}}) {
    const TestHull made = box_hull(half);
    REQUIRE(made.given_from_body.rotation == Quatd{1, 0, 0, 0});
    REQUIRE(norm(made.hull.half_extents - half) < 1e-15);
  }
}

// A corner of a cube of side a: V = a^3 / 6, centre at a / 4 on each axis, about it: Ixx = 3 m a^2 / 40 and
// Ixy entry of the tensor = m a^2 / 80.
TEST_CASE("The tetrahedron at the corner of a cube has the moments of the formula") {
  const double a = 0.3;
  const TestHull made = hull_around({{0, 0, 0}, {a, 0, 0}, {0, a, 0}, {0, 0, a}});
  REQUIRE(made.hull.topology.faces == 4);
  REQUIRE(made.hull.volume == Approx(a * a * a / 6).epsilon(1e-12));
  REQUIRE(norm(made.given_from_body.position - Vec3d{a / 4, a / 4, a / 4}) < 1e-15);
  const SymMat3d inertia = inertia_in_given(made);
  REQUIRE(inertia.xx == Approx(3 * a * a / 40).epsilon(1e-12));
  REQUIRE(inertia.xy == Approx(a * a / 80).epsilon(1e-12));
  REQUIRE(inertia.yz == Approx(a * a / 80).epsilon(1e-12));
}

TEST_CASE("Moments of random hulls agree with a count of random points inside") {
  Random random(3);
  for (int n = 0; n < 4; ++n) {
    const TestHull made = random_hull(random, 20, 0.2);
    const Solid solid = solid_of(view_of(made.hull), {});
    const Vec3d h = made.hull.half_extents;
    const int total = 200'000;
    int inside = 0;
    Vec3d first;
    SymMat3d second;
    for (int k = 0; k < total; ++k) {
      const Vec3d p{random(-h.x, h.x), random(-h.y, h.y), random(-h.z, h.z)};
      if (!std::all_of(solid.faces.begin(), solid.faces.end(),
                       [&](const auto& face) { return dot(face.normal, p) <= face.offset; }))
        continue;
      ++inside;
      first += p;
      second.xx += p.y * p.y + p.z * p.z;
      second.yy += p.x * p.x + p.z * p.z;
      second.zz += p.x * p.x + p.y * p.y;
      second.xy -= p.x * p.y;
      second.xz -= p.x * p.z;
      second.yz -= p.y * p.z;
    }
    // A share of p = V / V_box has a deviation of sqrt(p (1 - p) / total) < 0.0012; means of coordinates h /
    // sqrt(inside).
    const double box = 8 * h.x * h.y * h.z, count = inside, size = made.hull.bounding_radius;
    REQUIRE(made.hull.volume / box == Approx(count / total).margin(5 * 0.0012));
    REQUIRE(norm(first * (1 / count)) < 5 * size / std::sqrt(count));
    const double bound = 5 * size * size / std::sqrt(count);
    REQUIRE(made.hull.inertia_per_kg.x == Approx(second.xx / count).margin(bound));
    REQUIRE(made.hull.inertia_per_kg.y == Approx(second.yy / count).margin(bound));
    REQUIRE(made.hull.inertia_per_kg.z == Approx(second.zz / count).margin(bound));
    for (const double product : {second.xy, second.xz, second.yz}) REQUIRE(std::abs(product / count) < bound);
  }
}

TEST_CASE("Every face has all vertices below it, and every edge its two faces") {
  Random random(5);
  for (const std::uint32_t vertices : {4u, 8u, 20u, 64u}) {
    const TestHull made = random_hull(random, vertices, 0.2);
    const Hull& hull = made.hull;
    REQUIRE(hull.topology.faces == 2 * vertices - 4);
    REQUIRE(hull.topology.edges == 3 * vertices - 6);
    for (std::uint32_t f = 0; f < hull.topology.faces; ++f) {
      REQUIRE(norm(hull.normal(f)) == Approx(1).margin(1e-14));
      for (std::uint32_t i = 0; i < vertices; ++i) REQUIRE(dot(hull.normal(f), hull.vertex(i)) <= hull.offsets[f]);
      for (const std::uint8_t i : hull.topology.loop(f))
        REQUIRE(dot(hull.normal(f), hull.vertex(i)) == Approx(hull.offsets[f]).margin(1e-14));
    }
    for (std::uint32_t e = 0; e < hull.topology.edges; ++e) {
      const HullEdge& edge = hull.topology.edge[e];
      const Vec3d along = hull.vertex(edge.to) - hull.vertex(edge.from);
      REQUIRE(dot(cross(hull.normal(edge.left), hull.normal(edge.right)), along) > 0);
    }
  }
}

TEST_CASE("What is no solid is refused") {
  const std::vector<Vec3d> cube = corners({0.1, 0.1, 0.1}, {});
  Hull hull;
  Posed pose;
  HullTopology open;
  for (std::uint32_t f = 0; f < 5; ++f) (void)open.add_face(kBoxTopology.loop(f));
  REQUIRE(make_hull(cube, open, hull, pose) == HullFault::kNotClosed);

  HullTopology twisted;  // one face the wrong way round
  for (std::uint32_t f = 0; f < 6; ++f) {
    const auto loop = kBoxTopology.loop(f);
    std::vector<std::uint8_t> turned(loop.begin(), loop.end());
    if (f == 2) std::reverse(turned.begin(), turned.end());
    (void)twisted.add_face(turned);
  }
  REQUIRE(make_hull(cube, twisted, hull, pose) == HullFault::kNotClosed);

  std::vector<Vec3d> dented = cube;
  dented[7] = {0.02, 0.02, 0.02};
  REQUIRE(make_hull(dented, kBoxTopology, hull, pose) == HullFault::kNotConvex);

  std::vector<Vec3d> plane = cube;
  for (Vec3d& v : plane) v.z = 0;
  REQUIRE(make_hull(plane, kBoxTopology, hull, pose) == HullFault::kFlat);

  std::vector<Vec3d> wild = cube;
  wild[3].y = std::numeric_limits<double>::quiet_NaN();
  REQUIRE(make_hull(wild, kBoxTopology, hull, pose) == HullFault::kNotFinite);
}
