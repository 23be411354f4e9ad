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
inline Ruling rule_edge(const Mesh& mesh, std::uint32_t triangle, std::uint32_t k, const Vec3d& d) noexcept {
  const MeshTriangle& t = mesh.triangles[triangle];
  if (!(dot(mesh.normals[triangle], d) > 0.0)) return Ruling::kDropped;
  if (is_along_normal(mesh.normals[triangle], d, t.edge[k] == EdgeKind::kFlat ? kFaceSine : 0.0)) return Ruling::kFace;
  if (t.edge[k] == EdgeKind::kBoundary) return Ruling::kAllowed;
  // Beyond the neighbour's side of the edge too? In front of both, that is so at convex edges only. Of two that may
  // push, the first does.
  const std::uint32_t other = t.neighbour[k];
  const Vec3d along = mesh.corners[t.corner[k == 2 ? 0 : k + 1]] - mesh.corners[t.corner[k]];
  const Vec3d beyond_other = cross(mesh.normals[other], along);
  if (dot(beyond_other, d) < -1e-9 * norm(beyond_other)) return Ruling::kDropped;
  return other < triangle && dot(mesh.normals[other], d) > 0.0 ? Ruling::kDropped : Ruling::kAllowed;
}

// The same at a corner, c one of the triangle's.
inline Ruling rule_corner(const Mesh& mesh, std::uint32_t triangle, std::uint32_t c, const Vec3d& d) noexcept {
  if (!(dot(mesh.normals[triangle], d) > 0.0)) return Ruling::kDropped;
  const bool exposed = mesh.triangles[triangle].exposed;
  if (is_along_normal(mesh.normals[triangle], d, exposed ? 0.0 : kFaceSine)) return Ruling::kFace;
  if (!exposed) return Ruling::kDropped;
  const Vec3d& here = mesh.corners[c];
  for (const std::uint32_t other : mesh.triangles_at(c)) {
    if (other < triangle && dot(mesh.normals[other], d) > 0.0) return Ruling::kDropped;
    for (const std::uint32_t end : mesh.triangles[other].corner) {
      const Vec3d along = mesh.corners[end] - here;
      if (dot(along, d) > 1e-9 * norm(along)) return Ruling::kDropped;
    }
  }
  return Ruling::kAllowed;
}

// A solid overlaps the triangle, least along the unit vector u (from the triangle to it), which meets edge k first. The
// solid's other points may be anywhere, so where the surface goes on flat or rises it is the face that holds it.
inline Ruling rule_edge_axis(const Mesh& mesh, std::uint32_t triangle, std::uint32_t k, const Vec3d& u) noexcept {
  const MeshTriangle& t = mesh.triangles[triangle];
  if (is_along_normal(mesh.normals[triangle], u, kAxisSine)) return Ruling::kFace;
  if (t.edge[k] == EdgeKind::kFlat || t.edge[k] == EdgeKind::kConcave) return Ruling::kFace;
  constexpr double tolerance = 1e-6;
  if (t.edge[k] == EdgeKind::kBoundary)
    return dot(mesh.normals[triangle], u) >= -tolerance ? Ruling::kAllowed : Ruling::kDropped;
  const Vec3d along = mesh.corners[t.corner[k == 2 ? 0 : k + 1]] - mesh.corners[t.corner[k]];
  const Vec3d& other = mesh.normals[t.neighbour[k]];
  const Vec3d beyond_other = cross(other, along);
  // At the neighbour's normal and past it: the neighbour's.
  if (dot(beyond_other, u) < tolerance * norm(beyond_other) || is_along_normal(other, u, kAxisSine))
    return Ruling::kDropped;
  return Ruling::kAllowed;
}

inline Ruling rule_corner_axis(const Mesh& mesh, std::uint32_t triangle, std::uint32_t c, const Vec3d& u) noexcept {
  const Vec3d& n = mesh.normals[triangle];
  if (is_along_normal(n, u, kAxisSine)) return Ruling::kFace;
  const Vec3d& here = mesh.corners[c];
  bool blocked = false, falls = false;
  for (const std::uint32_t other : mesh.triangles_at(c)) {
    if (is_along_normal(mesh.normals[other], u, kAxisSine)) return Ruling::kDropped;
    for (const std::uint32_t end : mesh.triangles[other].corner) {
      const Vec3d along = mesh.corners[end] - here;
      const double length = norm(along);
      if (!(dot(along, u) > 1e-6 * length)) continue;
      blocked = true;
      falls = falls || dot(n, along) < -1e-3 * length;
    }
  }
  if (!blocked) return dot(n, u) >= -1e-6 ? Ruling::kAllowed : Ruling::kDropped;
  return falls ? Ruling::kDropped : Ruling::kFace;
}

}  // namespace tactus::physics
