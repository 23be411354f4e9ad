#include "rt/physics/collision/hull_distance.h"

#include <catch2/catch.hpp>

#include "tests/rt/physics/shapes/hull_support.h"

using namespace tactus;
using namespace tactus::physics;
using namespace tactus::physics::support;

namespace {

struct HullPair {
  Hull a, b;
  Posed pose_a, pose_b;

  HullSeparation gap(double margin) const {
    const Shape shape_a = Shape::convex(a, 0), shape_b = Shape::convex(b, 1);
    const LastFeatures none;
    const PairView pair{shape_a, shape_b, pose_a.rotation, pose_b.rotation, pose_b.position - pose_a.position,
                        margin,  none};
    return gap_of(relative_hulls(pair, view_of(a), view_of(b)), margin);
  }
  double distance() const {
    const std::vector<Hull> hulls{a, b};
    return physics::support::distance(solid_of(Shape::convex(a, 0), pose_a, hulls),
                                      solid_of(Shape::convex(b, 1), pose_b, hulls));
  }
};

HullPair random_pair(Random& random) {
  HullPair pair{random_hull(random, 4 + random.below(17), 0.1).hull,
                random_hull(random, 4 + random.below(17), 0.1).hull, random.pose(0.2), random.pose(0.2)};
  const Vec3d between = pair.pose_b.position - pair.pose_a.position;
  pair.pose_b.position = pair.pose_a.position + between * (random(0.05, 0.3) / norm(between));
  return pair;
}

}  // namespace

TEST_CASE("Two hulls are apart just where their distance exceeds the margin, and the gap is a bound of the distance") {
  Random random(31);
  int apart = 0, near = 0;
  for (int n = 0; n < 2000; ++n) {
    const HullPair pair = random_pair(random);
    const double distance = pair.distance();
    for (const double margin : {0.0, 1e-3, 2e-2}) {
      INFO("pair " << n << ", distance " << distance << ", margin " << margin);
      const HullSeparation gap = pair.gap(margin);
      if (distance > margin + 1e-9) REQUIRE(gap.apart);
      if (distance < margin - 1e-9 || distance == 0) REQUIRE_FALSE(gap.apart);
      if (gap.apart) {
        REQUIRE(gap.gap > margin);
        REQUIRE(gap.gap <= distance + 1e-9);
      }
      ++(gap.apart ? apart : near);
    }
  }
  REQUIRE((apart > 1000 && near > 1000));
}

TEST_CASE("Hulls that touch in a face, an edge or a corner, and a pose that is not finite, are not apart") {
  const Hull cube = box_hull({0.05, 0.05, 0.05}).hull;
  const double far = 0.1, diagonal = 0.05 + 0.05 * std::sqrt(2.0), corner = 0.05 + 0.05 * std::sqrt(3.0);
  const Quatd on_edge = turn({1, 0, 0}, 0.25 * 3.14159265358979);
  const Quatd on_corner = turn({1, 0, 0}, std::atan(std::sqrt(0.5))) * turn({0, 1, 0}, 0.25 * 3.14159265358979);
  for (const double lift : {-1e-6, 1e-6}) {
    const double margin = lift > 0 ? 2 * lift : 0.0;
    CHECK_FALSE(HullPair{cube, cube, {}, {{0, 0, far + lift}, {}}}.gap(margin).apart);
    CHECK_FALSE(HullPair{cube, cube, {}, {{0, 0, diagonal + lift}, on_edge}}.gap(margin).apart);
    CHECK_FALSE(HullPair{cube, cube, {}, {{0, 0, corner + lift}, on_corner}}.gap(margin).apart);
  }
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(HullPair{cube, cube, {}, {{nan, 0, 1}, {}}}.gap(0).apart);
  CHECK_FALSE(HullPair{cube, cube, {}, {{0, 0, 1}, {nan, 0, 0, 0}}}.gap(0).apart);
}

TEST_CASE("Bounds of a hull hold its vertices and touch one on every side") {
  Random random(32);
  for (int n = 0; n < 200; ++n) {
    const std::vector<Hull> hulls{random_hull(random, 4 + random.below(17), 0.1).hull};
    const Posed pose = random.pose(1.0);
    const Aabb box = bounds_of(Shape::convex(hulls[0], 0), pose, 0.25, hulls);
    Vec3d low{1e9, 1e9, 1e9}, high = -low;
    for (std::uint32_t i = 0; i < hulls[0].topology.vertices; ++i) {
      const Vec3d p = pose * hulls[0].vertex(i);
      for (int k = 0; k < 3; ++k) {
        low[k] = std::min(low[k], p[k]);
        high[k] = std::max(high[k], p[k]);
      }
    }
    for (int k = 0; k < 3; ++k) {
      REQUIRE(box.lower[k] == Approx(low[k] - 0.25).margin(1e-14));
      REQUIRE(box.upper[k] == Approx(high[k] + 0.25).margin(1e-14));
    }
  }
}
