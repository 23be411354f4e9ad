// Which triangles of a mesh can make a contact with a body, for a search that finds more than a list holds
// (mesh_query.h).
//
// A triangle inside a patch, away from the patch's rim, makes a contact only where a corner of the body is above it or
// below it: a vertex of a box or a hull, an end of a capsule's axis, the centre of a sphere. So the triangles of a flat
// floor that count are those at the body's corners, however fine the floor is. Any other triangle counts if it overlaps
// the box that holds the body. Frame: the mesh's. Units: m. Thread: [any]; no allocation.
// Bound: `kMaxHullVertices` corners for each triangle or node; they are computed once for each change of the patch.
#pragma once

#include <array>

#include "rt/physics/body_frame.h"
#include "rt/physics/shapes/hull.h"
#include "rt/physics/shapes/mesh.h"

namespace tactus::physics {

class BodyOnMesh {
 public:
  // `body`: its shape, which must outlive this object, and its pose in the mesh's frame. `reach`: the largest gap of a
  // contact [m].
  BodyOnMesh(const Mesh& mesh, PosedShape body, double reach, Hulls hulls) noexcept;

  bool can_touch(const MeshNode& node) noexcept {
    return node.inside_patch == kNoPatch || is_at_corner(node.inside_patch, node.box);
  }
  bool can_touch(std::uint32_t triangle) noexcept {
    const MeshTriangle& t = mesh_.triangles[triangle];
    return mesh_.is_inside_patch(t) ? is_at_corner(t.patch, mesh_.box_of(triangle)) : overlaps_box_of_body(t);
  }

 private:
  struct Corner {
    double at[3];  // in the patch's plane
    double slack;  // m: by how much a triangle's own plane may place it elsewhere
  };

  // True if a corner of the body is above or below the box, along the normal of the patch.
  bool is_at_corner(std::uint32_t patch, const Aabb& box) noexcept;
  bool overlaps_box_of_body(const MeshTriangle& t) const noexcept;
  void place_corners(std::uint32_t patch) noexcept;
  // `in_body`: in the body's frame. A corner that is higher than `highest` above the patch is left out [m].
  void place_corner(const MeshPatch& plane, const Vec3d& in_body, double highest) noexcept;

  const Mesh& mesh_;
  const Shape& shape_;
  Posed pose_;
  Axes axes_;  // of the body
  double reach_;
  Vec3d half_;  // of the box that holds the body, grown by the reach
  Hulls hulls_;
  std::uint32_t patch_{kNoPatch}, count_{0};  // corners_: of that patch
  bool any_part_{false};                      // the patch touches the body anywhere, not only at its corners
  std::array<Corner, kMaxHullVertices> corners_;
};

}  // namespace tactus::physics
