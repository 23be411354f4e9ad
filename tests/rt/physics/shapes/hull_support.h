// What the tests of hulls share: hulls by brute force, and distances by brute force over vertices, edges and faces.
#pragma once

#include <vector>

#include "rt/physics/shapes/hull_view.h"
#include "tests/rt/physics/collision/collide_support.h"

namespace tactus::physics::support {

struct TestHull {
  Hull hull;
  Posed given_from_body;
};

// Every three points with all others on one side are a face: points in general position, all of them on the hull.
inline TestHull hull_around(const std::vector<Vec3d>& points) {
  HullTopology topology;
  const auto n = static_cast<std::uint8_t>(points.size());
  topology.vertices = n;
  for (std::uint8_t i = 0; i < n; ++i)
    for (std::uint8_t j = static_cast<std::uint8_t>(i + 1); j < n; ++j)
      for (std::uint8_t k = static_cast<std::uint8_t>(j + 1); k < n; ++k) {
        const Vec3d normal = cross(points[j] - points[i], points[k] - points[i]);
        bool above = false, below = false;
        for (std::uint8_t m = 0; m < n && !(above && below); ++m) {
          if (m == i || m == j || m == k) continue;
          (dot(normal, points[m] - points[i]) > 0 ? above : below) = true;
        }
        if (above && below) continue;
        const std::uint8_t outward[3] = {i, above ? k : j, above ? j : k};
        (void)topology.add_face(outward);
      }
  TestHull made;
  if (make_hull(points, topology, made.hull, made.given_from_body) != HullFault::kNone) made.hull = {};
  return made;
}

// Points on an ellipsoid of half axes up to `size`.
inline TestHull random_hull(Random& random, std::uint32_t vertices, double size) {
  while (true) {
    const Vec3d axes{random(0.3, 1) * size, random(0.3, 1) * size, random(0.3, 1) * size};
    std::vector<Vec3d> points;
    for (std::uint32_t i = 0; i < vertices; ++i) points.push_back(scale(axes, random.direction()));
    TestHull made = hull_around(points);
    if (made.hull.topology.vertices == vertices && made.hull.least_width > 0.05 * size) return made;
  }
}

// A box with its own axes as a hull.
inline TestHull box_hull(const Vec3d& half) {
  const BoxHull box(half);
  std::vector<Vec3d> points;
  for (std::uint32_t k = 0; k < 8; ++k) points.push_back(box.view().vertex(k));
  TestHull made;
  if (make_hull(points, kBoxTopology, made.hull, made.given_from_body) != HullFault::kNone) made.hull = {};
  return made;
}

// An upright prism on a regular polygon: its two ends have `sides` vertices each.
inline TestHull prism_hull(std::uint32_t sides, double radius, double half_height) {
  HullTopology topology;
  std::vector<Vec3d> points;
  std::vector<std::uint8_t> top, bottom;
  for (std::uint32_t k = 0; k < sides; ++k) {
    const auto [s, c] = sin_cos(6.28318530717958647692 * k / sides);
    points.push_back({radius * c, radius * s, -half_height});
    points.push_back({radius * c, radius * s, half_height});
    const auto at = static_cast<std::uint8_t>(2 * k), next = static_cast<std::uint8_t>(2 * ((k + 1) % sides));
    const std::uint8_t side[4] = {at, next, static_cast<std::uint8_t>(next + 1), static_cast<std::uint8_t>(at + 1)};
    (void)topology.add_face(side);
    top.push_back(static_cast<std::uint8_t>(at + 1));
    bottom.insert(bottom.begin(), at);
  }
  topology.vertices = 2 * sides;
  (void)topology.add_face(top);
  (void)topology.add_face(bottom);
  TestHull made;
  if (make_hull(points, topology, made.hull, made.given_from_body) != HullFault::kNone) made.hull = {};
  return made;
}

// A hull in the world, as lists.
struct Solid {
  std::vector<Vec3d> vertices;
  std::vector<Segment> edges;
  struct Face {
    Vec3d normal;
    double offset;
    std::vector<Vec3d> loop;
  };
  std::vector<Face> faces;
};

inline Solid solid_of(const HullView& hull, const Posed& pose) {
  Solid solid;
  const HullTopology& t = *hull.topology;
  for (std::uint32_t i = 0; i < t.vertices; ++i) solid.vertices.push_back(pose * hull.vertex(i));
  for (std::uint32_t e = 0; e < t.edges; ++e)
    solid.edges.push_back({solid.vertices[t.edge[e].from], solid.vertices[t.edge[e].to]});
  for (std::uint32_t f = 0; f < t.faces; ++f) {
    Solid::Face face;
    for (const std::uint8_t i : t.loop(f)) face.loop.push_back(solid.vertices[i]);
    const Vec3d n = cross(face.loop[1] - face.loop[0], face.loop[2] - face.loop[0]);
    face.normal = n * (1 / norm(n));
    face.offset = dot(face.normal, face.loop[0]);
    solid.faces.push_back(face);
  }
  return solid;
}

inline Solid solid_of(const Shape& shape, const Posed& pose, Hulls hulls) {
  if (shape.kind == ShapeKind::kHull) return solid_of(view_of(hulls[shape.index]), pose);
  return solid_of(BoxHull(shape.half_extents).view(), pose);
}

inline bool meets(const Segment& s, const Solid& solid) {
  double enter = 0, leave = 1;
  for (const auto& face : solid.faces) {
    const double from = dot(face.normal, s.from) - face.offset, along = dot(face.normal, s.to - s.from);
    if (along == 0) {
      if (from > 0) return false;
      continue;
    }
    (along > 0 ? leave : enter) = along > 0 ? std::min(leave, -from / along) : std::max(enter, -from / along);
  }
  return enter <= leave;
}

inline double distance(const Vec3d& p, const Solid& solid) {
  bool inside = true;
  double least = 1e300;
  for (const auto& face : solid.faces) {
    const double height = dot(face.normal, p) - face.offset;
    if (height <= 0) continue;
    inside = false;
    bool above = true;
    for (std::size_t k = 0; k < face.loop.size(); ++k) {
      const Vec3d &a = face.loop[k], &b = face.loop[(k + 1) % face.loop.size()];
      above = above && dot(cross(face.normal, b - a), p - a) >= 0;
    }
    if (above) least = std::min(least, height);
  }
  if (inside) return 0;
  for (const Segment& edge : solid.edges) least = std::min(least, distance(p, edge));
  return least;
}

inline double distance(const Segment& s, const Solid& solid) {
  if (meets(s, solid)) return 0;
  double least = std::min(distance(s.from, solid), distance(s.to, solid));
  for (const Segment& edge : solid.edges)
    if (may_be_nearer(s, edge, least)) least = std::min(least, distance(s, edge));
  return least;
}

inline double distance(const Solid& a, const Solid& b) {
  for (const Segment& edge : a.edges)
    if (meets(edge, b)) return 0;
  for (const Segment& edge : b.edges)
    if (meets(edge, a)) return 0;
  double least = 1e300;
  for (const Vec3d& v : a.vertices) least = std::min(least, distance(v, b));
  for (const Vec3d& v : b.vertices) least = std::min(least, distance(v, a));
  for (const Segment& p : a.edges)
    for (const Segment& q : b.edges)
      if (may_be_nearer(p, q, least)) least = std::min(least, distance(p, q));
  return least;
}

// The gap between the shadows on n, from A to B.
inline double gap_along(const Solid& a, const Solid& b, const Vec3d& n) {
  double highest = -1e300, lowest = 1e300;
  for (const Vec3d& v : a.vertices) highest = std::max(highest, dot(n, v));
  for (const Vec3d& v : b.vertices) lowest = std::min(lowest, dot(n, v));
  return lowest - highest;
}

// The best of all axes: normals of all faces and cross products of all edges, whether they make a face or not.
inline double best_gap(const Solid& a, const Solid& b) {
  double best = -1e300;
  for (const auto& face : a.faces) best = std::max(best, gap_along(a, b, face.normal));
  for (const auto& face : b.faces) best = std::max(best, gap_along(a, b, -face.normal));
  for (const Segment& p : a.edges)
    for (const Segment& q : b.edges) {
      const Vec3d w = cross(p.to - p.from, q.to - q.from);
      const double length = norm(w);
      if (!(length > 0.006 * norm(p.to - p.from) * norm(q.to - q.from))) continue;
      best = std::max({best, gap_along(a, b, w * (1 / length)), gap_along(a, b, w * (-1 / length))});
    }
  return best;
}

}  // namespace tactus::physics::support
