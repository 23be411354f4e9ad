// A static triangle mesh: corners, triangles with their neighbours, patches and a tree of boxes; built at set-up (in
// sim/) and never changed. A fixed body has it; nothing that moves.
//
// The outside of a triangle is where its corners run counter-clockwise: it is touched from there only, and a body whose
// centre is on the other side passes. So thin meshes hold what moves less than its own half thickness in a step.
//
// How contacts with a mesh are keyed: a body may touch many triangles, and a pair of bodies has one manifold. So the
// triangles are gathered into patches, connected and flat to within the solver's slop, and each patch is to the contact
// table a fixed body of its own: it has an id (kFirstPatchId and up), so the pair's key, the warm start and the tape
// stay what they are, and one manifold of at most four points. A floor of a thousand triangles is one patch: what
// stands on it has the contact that it has on a plane, with the same features however the triangles run. Only the world
// knows that the slot of such a pair is that of the mesh's body. Rejected: a key with a third number (every key, sort
// and tape record longer, for scenes without meshes too), and one manifold per triangle (the number of points follows
// the triangulation, and impulses are lost at every seam).
//
// A mesh is a view: sim/ owns the arrays. Frame: the body's own; origin in the middle of the box that holds it. Units:
// m. Thread: [any], read only. Bound: what is built is limited by the loader; at most kMaxCornerTriangles meet at a
// corner.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "rt/base/ids.h"
#include "rt/physics/shapes/shape.h"

namespace tactus::physics {

inline constexpr std::uint32_t kNoTriangle = 0xffffffffu;
inline constexpr std::uint32_t kMaxCornerTriangles = 256;

// Ids from here on are of patches: they are in pair keys only, no body has one.
inline constexpr BodyId kFirstPatchId = 0x40000000u;

// How a triangle goes on across an edge. A fold by less than a milliradian counts as flat.
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
  std::uint32_t first{0}, count{0};  // of Mesh::order, everything below the node
  std::uint32_t second{0};           // the other child; 0 for a leaf
};

struct Mesh {
  std::span<const Vec3d> corners;           // m
  std::span<const MeshTriangle> triangles;  // patch by patch
  std::span<const Vec3d> normals;           // by triangle, unit
  std::span<const MeshPatch> patches;
  std::span<const MeshNode> nodes;  // the tree's root is the first
  std::span<const std::uint32_t> order;
  // The triangles that meet at a corner: around[around_start[c]] to around[around_start[c + 1]], ascending.
  std::span<const std::uint32_t> around_start, around;
  Vec3d half_extents;              // m: the box about the origin that holds it
  BodyId first_patch_id{kNoBody};  // of its patches, one after the other; no two meshes of a scene share one

  const Vec3d& place(const MeshTriangle& t, int k) const noexcept {
    return corners[t.corner[static_cast<std::size_t>(k)]];
  }
  bool is_inner_edge(const MeshTriangle& t, std::uint32_t k) const noexcept {  // between triangles of one patch
    return t.neighbour[k] != kNoTriangle && triangles[t.neighbour[k]].patch == t.patch;
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

// What a shape's index refers to. The worlds only look: the list stays where it is as long as they live. Each mesh
// belongs to one body: its patches have ids.
using Meshes = std::span<const Mesh>;

}  // namespace tactus::physics
