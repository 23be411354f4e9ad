#include "rt/physics/shapes/mesh_region.h"

namespace tactus::physics {

Ruling rule_edge(const Mesh& mesh, std::uint32_t triangle, std::uint32_t k, const Vec3d& d) noexcept {
  const MeshTriangle& t = mesh.triangles[triangle];
  if (!(dot(mesh.normals[triangle], d) > 0.0)) return Ruling::kDropped;
  if (is_along_normal(mesh.normals[triangle], d, t.edge[k] == EdgeKind::kFlat ? kFaceSine : 0.0)) return Ruling::kFace;
  if (t.edge[k] == EdgeKind::kBoundary) return Ruling::kAllowed;
  // The direction must also be beyond the neighbour's side of the edge; in front of both triangles that is so only at
  // convex edges. If both triangles may push, the one with the lower index does.
  const std::uint32_t other = t.neighbour[k];
  const Vec3d along = mesh.corners[t.corner[k == 2 ? 0 : k + 1]] - mesh.corners[t.corner[k]];
  const Vec3d beyond_other = cross(mesh.normals[other], along);
  if (dot(beyond_other, d) < -1e-9 * norm(beyond_other)) return Ruling::kDropped;
  return other < triangle && dot(mesh.normals[other], d) > 0.0 ? Ruling::kDropped : Ruling::kAllowed;
}

Ruling rule_corner(const Mesh& mesh, std::uint32_t triangle, std::uint32_t c, const Vec3d& d) noexcept {
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

Ruling rule_edge_axis(const Mesh& mesh, std::uint32_t triangle, std::uint32_t k, const Vec3d& u) noexcept {
  const MeshTriangle& t = mesh.triangles[triangle];
  if (is_along_normal(mesh.normals[triangle], u, kAxisSine)) return Ruling::kFace;
  if (t.edge[k] == EdgeKind::kFlat || t.edge[k] == EdgeKind::kConcave) return Ruling::kFace;
  constexpr double tolerance = 1e-6;
  if (t.edge[k] == EdgeKind::kBoundary)
    return dot(mesh.normals[triangle], u) >= -tolerance ? Ruling::kAllowed : Ruling::kDropped;
  const Vec3d along = mesh.corners[t.corner[k == 2 ? 0 : k + 1]] - mesh.corners[t.corner[k]];
  const Vec3d& other = mesh.normals[t.neighbour[k]];
  const Vec3d beyond_other = cross(other, along);
  // If u is along the neighbour's normal or beyond it, the neighbour makes the contact.
  if (dot(beyond_other, u) < tolerance * norm(beyond_other) || is_along_normal(other, u, kAxisSine))
    return Ruling::kDropped;
  return Ruling::kAllowed;
}

Ruling rule_corner_axis(const Mesh& mesh, std::uint32_t triangle, std::uint32_t c, const Vec3d& u) noexcept {
  const Vec3d& n = mesh.normals[triangle];
  if (is_along_normal(n, u, kAxisSine)) return Ruling::kFace;
  const Vec3d& here = mesh.corners[c];
  bool blocked = false, elsewhere = false;
  for (const std::uint32_t other : mesh.triangles_at(c)) {
    if (is_along_normal(mesh.normals[other], u, kAxisSine)) return Ruling::kDropped;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const auto& corners = mesh.triangles[other].corner;
      const std::uint32_t from = corners[k], to = corners[k == 2 ? 0 : k + 1];
      if (from != c && to != c) continue;
      const Vec3d along = mesh.corners[from == c ? to : from] - here;
      const double length = norm(along);
      if (!(dot(along, u) > 1e-6 * length)) continue;
      blocked = true;
      // A convex edge that rises along u may itself make the contact.
      elsewhere =
          elsewhere || dot(n, along) < -1e-3 * length ||
          (mesh.triangles[other].edge[k] == EdgeKind::kConvex && rule_edge_axis(mesh, other, k, u) == Ruling::kAllowed);
    }
  }
  if (!blocked) return dot(n, u) >= -1e-6 ? Ruling::kAllowed : Ruling::kDropped;
  return elsewhere ? Ruling::kDropped : Ruling::kFace;
}

}  // namespace tactus::physics
