// Finds the triangles of a mesh that a box may touch. Thread: [any]; pure, no allocation. Frame: the mesh's. Units: m.
//
// Bound: a stack of fixed size, kMaxMeshVisits nodes, kMaxBodyTriangles results. If there are more, those that the body
// can touch (body_on_mesh.h) are searched for; if these are too many, the ones nearest to the centre of the box are
// kept (ties by index), and the rest is counted; the count may be slightly too high.
#pragma once

#include "rt/base/bounded_vector.h"
#include "rt/physics/shapes/body_on_mesh.h"
#include "rt/physics/shapes/mesh.h"

namespace tactus::physics {

inline constexpr std::uint32_t kMaxBodyTriangles = 256;
inline constexpr std::uint32_t kMaxMeshVisits = 2048;
inline constexpr std::uint32_t kMaxMeshDepth = 48;  // of a tree that halves its triangles: much more than possible

struct TriangleList {
  FixedVector<std::uint32_t, kMaxBodyTriangles> triangles;  // ascending, so patch by patch
  std::uint32_t left_out{0};
};

// Finds the triangles whose boxes overlap `box`. `body`: whose box it is, grown by its reach; without it, all triangles
// count.
void find_triangles(const Mesh& mesh, const Aabb& box, TriangleList& found, BodyOnMesh* body = nullptr) noexcept;

// The same, from a list that is known to contain all of them.
void choose_triangles(const Mesh& mesh, const Aabb& box, std::span<const std::uint32_t> among,
                      TriangleList& found) noexcept;

// Pose of B in the frame of A, computed without world coordinates, which may be large.
constexpr Posed relative_pose(const Posed& world_from_a, const Posed& world_from_b) noexcept {
  return {rotate_inverse(world_from_a.rotation, world_from_b.position - world_from_a.position),
          conjugate(world_from_a.rotation) * world_from_b.rotation};
}

}  // namespace tactus::physics
