// Builds the convex hull of points for the real-time side. Thread: [setup]. Units: m. Frame: see physics/hull.h.
//
// The same points give the same hull: its vertices are in the order of the points, its faces in that of their vertices.
// Bound: a hull has at most kMaxHullVertices vertices, and is at least kMinHullWidth_m wide in every direction.
#pragma once

#include <vector>

#include "rt/base/result.h"
#include "rt/physics/shapes/hull.h"
#include "sim/geometry/mesh_files.h"

namespace tactus::sim {

inline constexpr double kMinHullWidth_m = 1e-4;

struct BuiltHull {
  physics::Hull hull;
  Posed given_from_body;        // pose of the hull's frame in the frame of the points
  std::vector<Vec3d> vertices;  // the points that are its vertices; building from these alone gives the same hull
};

// Faces that are coplanar to a millionth of the size are merged. An error says what is wrong and what is accepted.
Result<BuiltHull> build_hull(std::span<const Vec3d> points);

// The surface of the hull of any number of points, as triangles; its corners are the points that are vertices. An error
// where fewer than four points, or points in a plane, make no solid.
Result<TriangleSoup> hull_surface(std::span<const Vec3d> points);

}  // namespace tactus::sim
