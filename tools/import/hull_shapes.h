// Convex hulls of at most 64 vertices that replace other shapes, with the largest deviation between the two surfaces.
//
// Units: m. Frame: the shape's own. Thread: any normal one. Bound: points x kMaxHullVertices x faces. Errors: one line,
// of a solid that is too thin.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "rt/base/result.h"
#include "rt/physics/shapes/shape.h"
#include "sim/geometry/mesh_files.h"

namespace tactus::scene_import {

struct HullPoints {
  std::vector<Vec3d> points;  // the vertices
  double deviation_m{0};      // the largest distance of a point of one surface to the other; 0: the same surface
};

// 62 points along the symmetry axes of an icosahedron, so that all three planes of symmetry stay; half as much of the
// deviation outside of the surface as inside.
HullPoints ellipsoid_hull(const Vec3d& half_axes);

// The convex hull of the points, thinned to 64 vertices where it has more: the farthest point first. `deviation_m` is
// then that between the whole hull and the thinned one.
Result<HullPoints> hull_of(std::span<const Vec3d> points);

// The surface of the hull of at most 64 vertices that the points make in a scene, as triangles.
Result<sim::TriangleSoup> surface_of(std::span<const Vec3d> points);

// The boxes about points, and about the corners of triangles, along the axes; of one point at least.
physics::Aabb box_of(std::span<const Vec3d> points);
physics::Aabb box_of(std::span<const std::array<Vec3d, 3>> triangles);

// The largest distance of a point to the first one: between half the diameter of the set and the diameter.
double extent_of(std::span<const Vec3d> points);

double distance_to_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c);

// The distance of a point to the nearest of the triangles.
double distance_to(const Vec3d& point, const sim::TriangleSoup& surface);

}  // namespace tactus::scene_import
