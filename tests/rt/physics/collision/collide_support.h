// What the tests of narrow phase share: seeded random poses and shapes, and distances by brute force over vertices
// and edges, independent of separating axes.
#pragma once

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>

#include "rt/physics/collision/manifold.h"
#include "tests/support/random.h"

namespace tactus::physics::support {

using Random = tactus::test::Random;
using tactus::test::tries;

inline Quatd turn(const Vec3d& axis, double angle_rad) { return quat_from_rotation_vector(axis * angle_rad); }

inline Manifold touch(const Shape& a, const Posed& pose_a, const Shape& b, const Posed& pose_b, double margin) {
  AxisCache cache;
  return collide({a, pose_a}, {b, pose_b}, {.margin = margin}, cache);
}

inline void require_vec(const Vec3d& v, const Vec3d& expected) {
  REQUIRE(v.x == Approx(expected.x).margin(1e-12));
  REQUIRE(v.y == Approx(expected.y).margin(1e-12));
  REQUIRE(v.z == Approx(expected.z).margin(1e-12));
}

// The point nearest to `at`, which is given from the centre of A or of B.
inline const ManifoldPoint& point_near(const Manifold& m, const Vec3d& at, Vec3d ManifoldPoint::*from) {
  std::uint32_t best = 0;
  for (std::uint32_t i = 1; i < m.count; ++i)
    if (norm(m.points[i].*from - at) < norm(m.points[best].*from - at)) best = i;
  return m.points[best];
}

inline double least_separation(const Manifold& m) {
  double least = m.points[0].separation;
  for (std::uint32_t i = 1; i < m.count; ++i) least = std::min(least, m.points[i].separation);
  return least;
}

// --- distances of skeletons: a point, a segment, a box

struct Segment {
  Vec3d from, to;
};

inline double distance(const Vec3d& point, const Segment& s) {
  const Vec3d along = s.to - s.from;
  const double length_squared = norm_squared(along);
  const double t = length_squared > 0 ? std::clamp(dot(point - s.from, along) / length_squared, 0.0, 1.0) : 0.0;
  return norm(s.from + along * t - point);
}

// Ternary search of a convex function, simple rather than fast.
inline double distance(const Segment& a, const Segment& b) {
  double low = 0, high = 1;  // each round leaves two thirds: 60 rounds leave 3e-11 of the segment
  for (int i = 0; i < 60; ++i) {
    const double s = low + (high - low) / 3, t = high - (high - low) / 3;
    if (distance(a.from + (a.to - a.from) * s, b) < distance(a.from + (a.to - a.from) * t, b))
      high = t;
    else
      low = s;
  }
  return std::min(
      {distance(a.from + (a.to - a.from) * (0.5 * (low + high)), b), distance(a.from, b), distance(a.to, b)});
}

struct PosedBox {
  Vec3d half;
  Posed pose;

  Vec3d corner(unsigned k) const {
    return pose * Vec3d{k & 1 ? half.x : -half.x, k & 2 ? half.y : -half.y, k & 4 ? half.z : -half.z};
  }
  std::array<Segment, 12> edges() const {
    std::array<Segment, 12> result;
    std::size_t n = 0;
    for (unsigned axis = 1; axis <= 4; axis *= 2)
      for (unsigned k = 0; k < 8; ++k)
        if (!(k & axis)) result[n++] = {corner(k), corner(k | axis)};
    return result;
  }
};

inline double distance(const Vec3d& point, const PosedBox& box) {
  const Vec3d p = inverse(box.pose) * point;
  return norm(Vec3d{p.x - std::clamp(p.x, -box.half.x, box.half.x), p.y - std::clamp(p.y, -box.half.y, box.half.y),
                    p.z - std::clamp(p.z, -box.half.z, box.half.z)});
}

// Does the segment meet the box? Slab by slab.
inline bool meets(const Segment& segment, const PosedBox& box) {
  const Vec3d from = inverse(box.pose) * segment.from, along = inverse(box.pose) * segment.to - from;
  double enter = 0, leave = 1;
  for (int i = 0; i < 3; ++i) {
    if (along[i] == 0) {
      if (std::abs(from[i]) > box.half[i]) return false;
      continue;
    }
    const double t0 = (-box.half[i] - from[i]) / along[i], t1 = (box.half[i] - from[i]) / along[i];
    enter = std::max(enter, std::min(t0, t1));
    leave = std::min(leave, std::max(t0, t1));
  }
  return enter <= leave;
}

inline double distance(const Segment& segment, const PosedBox& box) {
  if (meets(segment, box)) return 0;
  double least = std::min(distance(segment.from, box), distance(segment.to, box));
  for (const Segment& edge : box.edges()) least = std::min(least, distance(segment, edge));
  return least;
}

// Two convex polyhedra overlap just where an edge of one meets the other (an edge inside meets it too).
inline bool overlap(const PosedBox& a, const PosedBox& b) {
  for (const Segment& edge : a.edges())
    if (meets(edge, b)) return true;
  for (const Segment& edge : b.edges())
    if (meets(edge, a)) return true;
  return false;
}

// Spheres about the segments: spares most of the searches.
inline bool may_be_nearer(const Segment& a, const Segment& b, double than) {
  return 0.5 * (norm(a.from + a.to - b.from - b.to) - norm(a.to - a.from) - norm(b.to - b.from)) < than;
}

inline double distance(const PosedBox& a, const PosedBox& b) {
  if (overlap(a, b)) return 0;
  double least = distance(a.corner(0), b);
  for (unsigned k = 0; k < 8; ++k) least = std::min({least, distance(a.corner(k), b), distance(b.corner(k), a)});
  const auto edges_b = b.edges();
  for (const Segment& edge_a : a.edges())
    for (const Segment& edge_b : edges_b)
      if (may_be_nearer(edge_a, edge_b, least)) least = std::min(least, distance(edge_a, edge_b));
  return least;
}

inline Segment axis_of(const Shape& capsule, const Posed& pose) {
  return {pose * Vec3d{0, 0, -capsule.half_length}, pose * Vec3d{0, 0, capsule.half_length}};
}

// Signed for round shapes against each other and against a plane; a box's inside counts as distance 0 to its skeleton.
inline double reference_distance(const Shape& a, const Posed& pose_a, const Shape& b, const Posed& pose_b) {
  if (a.kind > b.kind) return reference_distance(b, pose_b, a, pose_a);
  const double radii = a.radius + b.radius;
  if (b.kind == ShapeKind::kPlane) {
    const Posed plane_from_a = inverse(pose_b) * pose_a;
    if (a.kind == ShapeKind::kSphere) return plane_from_a.position.z - radii;
    if (a.kind == ShapeKind::kCapsule) {
      const Segment axis = axis_of(a, plane_from_a);
      return std::min(axis.from.z, axis.to.z) - radii;
    }
    double lowest = PosedBox{a.half_extents, plane_from_a}.corner(0).z;
    for (unsigned k = 1; k < 8; ++k) lowest = std::min(lowest, PosedBox{a.half_extents, plane_from_a}.corner(k).z);
    return lowest;
  }
  const PosedBox box_b{b.half_extents, pose_b};
  if (a.kind == ShapeKind::kSphere) {
    if (b.kind == ShapeKind::kSphere) return norm(pose_a.position - pose_b.position) - radii;
    if (b.kind == ShapeKind::kCapsule) return distance(pose_a.position, axis_of(b, pose_b)) - radii;
    return distance(pose_a.position, box_b) - radii;
  }
  if (a.kind == ShapeKind::kCapsule) {
    if (b.kind == ShapeKind::kCapsule) return distance(axis_of(a, pose_a), axis_of(b, pose_b)) - radii;
    return distance(axis_of(a, pose_a), box_b) - radii;
  }
  return distance(PosedBox{a.half_extents, pose_a}, box_b);
}

inline Shape random_shape(Random& random, ShapeKind kind) {
  switch (kind) {
    case ShapeKind::kSphere:
      return Shape::sphere(random(0.01, 0.1));
    case ShapeKind::kCapsule:
      return Shape::capsule(random(0.005, 0.05), random(0.01, 0.15));
    case ShapeKind::kBox:
      return Shape::box(
          {random.log_uniform(3e-4, 0.15), random.log_uniform(3e-3, 0.15), random.log_uniform(3e-3, 0.15)});
    case ShapeKind::kPlane:
    case ShapeKind::kHull:
    case ShapeKind::kMesh:
    case ShapeKind::kCompound:
    case ShapeKind::kCylinder:
    case ShapeKind::kCone:
      break;
  }
  return Shape::plane();
}

}  // namespace tactus::physics::support
