// The triangles of meshes near moving bodies, found beforehand by somebody else: so that the haptic thread looks at a
// short list and not at a tree. Thread: [any]. Frame: the mesh's. Units: m.
//
// A list holds every triangle whose box overlaps its region. As long as the body stays inside, the list gives just what
// the tree would, so it never shows in a result; a body that has left its region (the other world is late) or has no
// list asks the tree, which is bounded too (mesh_query.h).
#pragma once

#include <span>

#include "rt/physics/shapes/mesh_query.h"

namespace tactus::physics {

struct NearRegion {
  BodyId body{kNoBody};
  std::uint32_t mesh{0};             // in the list of the world
  std::uint32_t first{0}, count{0};  // of the triangles
  Aabb box;
};

struct NearTriangles {
  std::span<const NearRegion> regions;       // by body, then by mesh
  std::span<const std::uint32_t> triangles;  // of each region ascending

  void find(const Mesh& mesh, BodyId body, std::uint32_t mesh_index, const Aabb& box,
            TriangleList& found) const noexcept;
};

}  // namespace tactus::physics
