// A static triangle mesh: corners, triangles with their neighbours, patches and a tree of boxes; built at set-up (in
// sim/) and never changed. Only fixed bodies have meshes.
//
// Triangles are one-sided: the outside is where the corners run counter-clockwise. A body whose centre is on the other
// side is not in contact. So a thin mesh stops only bodies that move less than their own half thickness in a step.
//
// Keys of contacts with a mesh: a body may touch many triangles, but a pair of bodies has one manifold. So the
// triangles are grouped into patches, connected and flat to within the solver's slop, and the contact table treats each
// patch as a fixed body with its own id (kFirstPatchId and up) and one manifold of at most four points; the pair's key,
// the warm start and the tape keep their form. A floor of a thousand triangles is one patch: a body on it has the same
// contact as on a plane, with the same features for any triangulation. Only the world maps the slot of such a pair to
// the mesh's body. Rejected: a key with a third number (longer keys, sorts and tape records, also for scenes without
// meshes), and one manifold per triangle (the number of points depends on the triangulation, and impulses are lost at
// every seam).
//
// A mesh is a view: sim/ owns the arrays. Frame: the body's own; origin at the centre of the enclosing box. Units: m.
// Thread: [any], read only. Bound: set by the loader; at most kMaxCornerTriangles meet at a corner.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "rt/base/ids.h"
#include "rt/physics/shapes/shape.h"

namespace tactus::physics {

inline constexpr std::uint32_t kNoTriangle = 0xffffffffu;
inline constexpr std::uint32_t kNoPatch = 0xffffffffu;
inline constexpr std::uint32_t kMaxCornerTriangles = 256;

// First id of patches: they appear only in pair keys, no body has one.
inline constexpr BodyId kFirstPatchId = 1u << (kIdBits - 1);

// Fold of the surface across an edge. Below one milliradian it counts as flat.
enum class EdgeKind : std::uint8_t { kFlat = 0, kConvex = 1, kConcave = 2, kBoundary = 3 };

struct MeshTriangle {
  std::array<std::uint32_t, 3> corner{};     // counter-clockwise seen from outside
  std::array<std::uint32_t, 3> neighbour{};  // across edge k, from corner k to the next; kNoTriangle at a boundary
  std::array<EdgeKind, 3> edge{};
  bool exposed{false};  // one of its corners is on a convex or boundary edge; otherwise only its face can be touched
  std::uint32_t patch{0};
  friend bool operator==(const MeshTriangle&, const MeshTriangle&) = default;
};

struct MeshPatch {
  Vec3d normal;     // unit, outward
  double offset{};  // m: the plane is normal . x = offset; the patch's corners are within the slop of it
};

// Nodes are in depth-first order: the first child of a node follows it.
struct MeshNode {
  Aabb box;
  std::uint32_t first{0}, count{0};      // range in Mesh::order of all triangles below the node
  std::uint32_t second{0};               // the other child; 0 for a leaf
  std::uint32_t inside_patch{kNoPatch};  // that of all triangles below the node, if each is inside it
};

struct Mesh {
  std::span<const Vec3d> corners;           // m
  std::span<const MeshTriangle> triangles;  // patch by patch
  std::span<const Vec3d> normals;           // by triangle, unit
  std::span<const MeshPatch> patches;
  std::span<const MeshNode> nodes;  // the first is the root
  std::span<const std::uint32_t> order;
  // The triangles that meet at a corner: around[around_start[c]] to around[around_start[c + 1]], ascending.
  std::span<const std::uint32_t> around_start, around;
  Vec3d half_extents;              // m: the box about the origin that encloses it
  BodyId first_patch_id{kNoBody};  // ids of its patches are consecutive; every mesh of a scene has ids of its own

  const Vec3d& place(const MeshTriangle& t, int k) const noexcept {
    return corners[t.corner[static_cast<std::size_t>(k)]];
  }
  bool is_inner_edge(const MeshTriangle& t, std::uint32_t k) const noexcept {  // between triangles of one patch
    return t.neighbour[k] != kNoTriangle && triangles[t.neighbour[k]].patch == t.patch;
  }
  const MeshPatch& patch_of(PairKey key) const noexcept { return patches[key.high() - first_patch_id]; }
  // True if its neighbours are of the same patch, and none of its corners is on a convex or boundary edge.
  bool is_inside_patch(const MeshTriangle& t) const noexcept {
    return !t.exposed && is_inner_edge(t, 0) && is_inner_edge(t, 1) && is_inner_edge(t, 2);
  }
  std::span<const std::uint32_t> triangles_at(std::uint32_t c) const noexcept {
    return around.subspan(around_start[c], around_start[c + 1] - around_start[c]);
  }
  Aabb box_of(std::uint32_t triangle) const noexcept {
    const MeshTriangle& t = triangles[triangle];
    Aabb box{place(t, 0), place(t, 0)};
    for (int k = 1; k < 3; ++k)
      for (int i = 0; i < 3; ++i) {
        box.lower[i] = smaller(box.lower[i], place(t, k)[i]);
        box.upper[i] = larger(box.upper[i], place(t, k)[i]);
      }
    return box;
  }
};

// The list to which mesh shapes refer. Read only; must stay at its address as long as the worlds exist. Each mesh
// belongs to one body, because its patches have ids.
using Meshes = std::span<const Mesh>;

}  // namespace tactus::physics
