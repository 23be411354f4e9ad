#include "rt/physics/collision/box_triangle.h"

#include <catch2/catch.hpp>
#include <set>

#include "tests/rt/physics/shapes/hull_support.h"

using namespace tactus;
using namespace tactus::physics;
using namespace tactus::physics::support;

namespace {

struct RandomPair {
  BoxTriangle pair;
  BoxHull box;

  explicit RandomPair(const BoxTriangle& p) : pair(p), box(p.half) {
    pair.middle = (pair.corner[0] + pair.corner[1] + pair.corner[2]) * (1.0 / 3.0);
  }
  // Gap between the projections onto the unit vector n, which points from the triangle to the box.
  double separation_along(const Vec3d& n) const {
    double box_low = dot(n, box.view().vertex(0)), triangle_high = dot(n, pair.corner[0]);
    for (std::uint32_t i = 1; i < 8; ++i) box_low = std::min(box_low, dot(n, box.view().vertex(i)));
    for (const Vec3d& c : pair.corner) triangle_high = std::max(triangle_high, dot(n, c));
    return box_low - triangle_high;
  }
  double best_of_box_faces() const {
    double best = -1e9;
    for (std::uint32_t f = 0; f < 6; ++f) best = std::max(best, separation_along(-box.view().normal(f)));
    return best;
  }
  double best_of_faces() const {
    const Vec3d n = direction_of(cross(pair.corner[1] - pair.corner[0], pair.corner[2] - pair.corner[0]));
    return std::max({best_of_box_faces(), separation_along(n), separation_along(-n)});
  }
  // Over the axes of two edges that are not parallel, in the direction in which the triangle's edge is its farthest.
  double best_of_edges() const {
    double best = -1e9;
    for (std::size_t e = 0; e < 3; ++e)
      for (int axis = 0; axis < 3; ++axis) {
        const Vec3d &from = pair.corner[e], &to = pair.corner[(e + 1) % 3], &third = pair.corner[(e + 2) % 3];
        Vec3d along;
        along[axis] = 1.0;
        const Vec3d w = cross(direction_of(to - from), along);
        if (norm(w) < 0.006) continue;
        const Vec3d n = dot(w, third - from) < 0.0 ? direction_of(w) : -direction_of(w);
        best = std::max(best, separation_along(n));
      }
    return best;
  }
  static Vec3d direction_of(const Vec3d& v) { return v * (1.0 / norm(v)); }
};

RandomPair random_pair(Random& random) {
  BoxTriangle pair{{random(0.02, 0.1), random(0.02, 0.1), random(0.02, 0.1)}, {}, {}};
  const Vec3d at = random.vector(0.15);
  for (Vec3d& corner : pair.corner) corner = at + random.vector(0.1);
  return RandomPair(pair);
}

}  // namespace

TEST_CASE("The best face of a box against a triangle is the best of all six") {
  Random random(41);
  std::set<std::uint32_t> faces;
  for (int n = 0; n < 2000; ++n) {
    const RandomPair at = random_pair(random);
    const BoxFace best = best_box_face(at.pair);
    INFO("pair " << n);
    REQUIRE(best.separation == Approx(at.best_of_box_faces()).margin(1e-12));
    REQUIRE(at.separation_along(-at.box.view().normal(best.face)) == Approx(best.separation).margin(1e-12));
    faces.insert(best.face);
  }
  REQUIRE(faces.size() == 6);
}

TEST_CASE("The best edges of a box and a triangle separate as far as the best axis of any two edges") {
  Random random(42);
  int found = 0, not_found = 0;
  std::set<std::uint32_t> edges, of_box;
  for (int n = 0; n < 5000; ++n) {
    const RandomPair at = random_pair(random);
    const double by_faces = at.best_of_faces(), by_edges = at.best_of_edges();
    const EdgeAxis best = best_box_edges(at.pair, by_faces);
    INFO("pair " << n << ", faces " << by_faces << ", edges " << by_edges);
    REQUIRE(std::max(by_faces, best.separation) == Approx(std::max(by_faces, by_edges)).margin(1e-12));
    if (by_edges < by_faces - 1e-12) REQUIRE_FALSE(best.found);
    ++(best.found ? found : not_found);
    if (!best.found) continue;
    // Both edges are where the two bodies meet along the normal.
    REQUIRE(norm(best.normal) == Approx(1.0));
    const HullEdge& edge = kBoxTopology.edge[best.other_edge];
    const Vec3d &a = at.pair.corner[best.edge], &b = at.pair.corner[(best.edge + 1) % 3];
    for (const Vec3d& on_triangle : {a, b})
      for (const std::uint32_t vertex : {edge.from, edge.to})
        REQUIRE(dot(best.normal, at.box.view().vertex(vertex) - on_triangle) == Approx(best.separation).margin(1e-12));
    edges.insert(best.edge);
    of_box.insert(best.other_edge);
  }
  REQUIRE((found > 500 && not_found > 500));
  REQUIRE((edges.size() == 3 && of_box.size() == 12));
}

TEST_CASE("Edges of a box and a triangle that are parallel give no axis") {
  const RandomPair at({{0.1, 0.1, 0.1}, {Vec3d{-0.2, 0.3, 0}, Vec3d{0.2, 0.3, 0}, Vec3d{0, 0.5, 0}}, {}});
  const EdgeAxis best = best_box_edges(at.pair, -1.0);
  REQUIRE(best.found);
  REQUIRE_FALSE(
      (best.edge == 0 && (kBoxTopology.edge[best.other_edge].from ^ kBoxTopology.edge[best.other_edge].to) == 1));
}
