// Lists of mesh triangles near moving bodies, prepared outside the haptic thread, which then searches a short list
// instead of a tree. Thread: [any]. Frame: the mesh's. Units: m.
//
// A list holds every triangle whose box overlaps its region. While the body's box is inside the region, the list gives
// the same result as the tree. A body that has left its region (the other world is late) or has no list searches the
// tree, whose work is bounded, too (mesh_query.h).
#pragma once

#include <span>

#include "rt/physics/shapes/mesh_query.h"

namespace tactus::physics {

struct NearRegion {
  BodyId body{kNoBody};
  std::uint32_t mesh{0};             // index in the world's list
  std::uint32_t first{0}, count{0};  // range in `triangles`
  Aabb box;
};

struct NearTriangles {
  std::span<const NearRegion> regions;       // sorted by body, then by mesh
  std::span<const std::uint32_t> triangles;  // ascending in each region

  void find(const Mesh& mesh, BodyId body, std::uint32_t mesh_index, const Aabb& box, TriangleList& found,
            BodyOnMesh* body_on_mesh = nullptr) const noexcept;
};

}  // namespace tactus::physics
