// Valid contact directions at the edges and corners of a mesh. Inside narrow phase. Thread: [any]; pure. Frame: the
// mesh's. Bound: at a corner, visits every triangle that meets there (kMaxCornerTriangles) once.
//
// An isolated triangle pushes sideways with its edges even where the surface continues, so that a body sliding over a
// seam would feel a bump. Therefore an edge may push only in directions of its own Voronoi region, between the normals
// of its two triangles, and a corner only if no edge is nearer; all other directions belong to a neighbour or to the
// face.
// Source: Voronoi regions of features, Ericson 2005, section 5.1.5.
#pragma once

#include "rt/physics/shapes/mesh.h"

namespace tactus::physics {

enum class Ruling : std::uint32_t {
  kAllowed = 0,  // the feature may push in that direction
  kFace = 1,     // the triangle's face pushes, along its normal
  kDropped = 2,  // a neighbour pushes here, or nothing does
};

// Directions within a quarter of a degree of the face's normal count as the face's: flat folds (mesh.h) are within
// that.
inline constexpr double kFaceSine = 4e-3;

// For the separating axis of a solid at a convex edge the limit is a hundredth of a degree: on a floor with slight
// slopes, face normals in place of the axis would slow sliding bodies.
inline constexpr double kAxisSine = 2e-4;

// Direction in the triangle's plane, normal to its edge k, away from the triangle. Not of length 1.
inline Vec3d outward_of_edge(const Mesh& mesh, std::uint32_t triangle, std::uint32_t k) noexcept {
  const MeshTriangle& t = mesh.triangles[triangle];
  const Vec3d& from = mesh.corners[t.corner[k]];
  const Vec3d& to = mesh.corners[t.corner[k == 2 ? 0 : k + 1]];
  return cross(to - from, mesh.normals[triangle]);
}

// True if the sine of the angle between `d` and the normal is at most `sine`, or `d` deviates from it by at most 0.1
// um.
inline bool is_along_normal(const Vec3d& normal, const Vec3d& d, double sine = kFaceSine) noexcept {
  const double up = dot(normal, d);
  return up >= 0.0 && norm(d - normal * up) <= sine * up + 1e-7;
}

// For a point whose nearest point is on edge k of the triangle; `d` [m, or of length 1] leads from there to the point.
Ruling rule_edge(const Mesh& mesh, std::uint32_t triangle, std::uint32_t k, const Vec3d& d) noexcept;

// The same for corner c of the triangle.
Ruling rule_corner(const Mesh& mesh, std::uint32_t triangle, std::uint32_t c, const Vec3d& d) noexcept;

// For a solid that overlaps the triangle least along the unit vector u (from the triangle to the solid), with edge k
// the first to be met. Other points of the solid may be anywhere, so where the surface continues flat or rises, the
// face pushes.
Ruling rule_edge_axis(const Mesh& mesh, std::uint32_t triangle, std::uint32_t k, const Vec3d& u) noexcept;

Ruling rule_corner_axis(const Mesh& mesh, std::uint32_t triangle, std::uint32_t c, const Vec3d& u) noexcept;

}  // namespace tactus::physics
