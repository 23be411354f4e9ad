// Inside narrow phase: which directions the edges and corners of a mesh may push in. Thread: [any]; pure. Frame: the
// mesh's. Bound: at a corner, every triangle that meets there (kMaxCornerTriangles) is looked at once.
//
// Seen alone, a triangle pushes sideways with its edges, also where the surface goes on: a body that slides over a seam
// feels a bump. On a surface an edge may push only into its own Voronoi region, between the normals of its two
// triangles, and a corner only where no edge leads nearer: all else is a neighbour's to push, or the face's own.
// Source: Voronoi regions of features, Ericson 2005, section 5.1.5.
#pragma once

#include "rt/physics/shapes/mesh.h"

namespace tactus::physics {

enum class Ruling : std::uint32_t {
  kAllowed = 0,  // the feature may push in that direction
  kFace = 1,     // the triangle's face is what pushes here, along its normal
  kDropped = 2,  // a neighbour pushes here, or nothing does
};

// A direction within a quarter of a degree of the face's normal is the face's: what is flat (mesh.h) is within that.
inline constexpr double kFaceSine = 4e-3;

// At a convex edge a solid's axis is the face's within a hundredth of a degree only: on a floor of slight slopes, face
// normals in place of the axis brake what slides.
inline constexpr double kAxisSine = 2e-4;

// In the plane of the triangle, across its edge k, away from it. Not of length 1.
inline Vec3d outward_of_edge(const Mesh& mesh, std::uint32_t triangle, std::uint32_t k) noexcept {
  const MeshTriangle& t = mesh.triangles[triangle];
  const Vec3d& from = mesh.corners[t.corner[k]];
  const Vec3d& to = mesh.corners[t.corner[k == 2 ? 0 : k + 1]];
  return cross(to - from, mesh.normals[triangle]);
}

// Is `d` at most that far from the normal, or 0.1 um beside it?
inline bool is_along_normal(const Vec3d& normal, const Vec3d& d, double sine = kFaceSine) noexcept {
  const double up = dot(normal, d);
  return up >= 0.0 && norm(d - normal * up) <= sine * up + 1e-7;
}

// Where a point is nearest to edge k of the triangle, and `d` [m, or of length 1] leads from there to it.
Ruling rule_edge(const Mesh& mesh, std::uint32_t triangle, std::uint32_t k, const Vec3d& d) noexcept;

// The same at a corner, c one of the triangle's.
Ruling rule_corner(const Mesh& mesh, std::uint32_t triangle, std::uint32_t c, const Vec3d& d) noexcept;

// A solid overlaps the triangle, least along the unit vector u (from the triangle to it), which meets edge k first. The
// solid's other points may be anywhere, so where the surface goes on flat or rises it is the face that holds it.
Ruling rule_edge_axis(const Mesh& mesh, std::uint32_t triangle, std::uint32_t k, const Vec3d& u) noexcept;

Ruling rule_corner_axis(const Mesh& mesh, std::uint32_t triangle, std::uint32_t c, const Vec3d& u) noexcept;

}  // namespace tactus::physics
