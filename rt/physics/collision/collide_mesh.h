// The manifold of a body and a patch of a mesh: at most four points with one normal.
//
// A is the body, B the mesh. Normals are those of faces, and those of edges and corners only where mesh_region.h allows
// it. Points where the body's edges cross seams inside the patch are omitted, because the surface continues there.
// Features are the body's corners, ends and edges where possible, so that they persist when the body slides over a
// seam.
// Frame: world axes; points from each body's centre. Units: m. Thread: [any]; pure, no allocation.
// Bound: visits each triangle of the list once; a triangle at the patch's rim costs one separating-axis test of hulls
// (hull_pair.h).
// Source: separating axes, Gottschalk 1996; clipping, Sutherland and Hodgman 1974.
#pragma once

#include "rt/physics/collision/collide.h"
#include "rt/physics/shapes/hull_view.h"
#include "rt/physics/shapes/mesh.h"

namespace tactus::physics {

// The triangles of one patch that are near a body.
struct PosedPatch {
  const Mesh& mesh;
  const Posed& world_from_mesh;
  std::span<const std::uint32_t> triangles;
};

// Count 0 if nothing is within the margin, or if the centre of A is behind the triangles. `hulls`: see collide().
Manifold collide_patch(PosedShape a, const PosedPatch& patch, const ManifoldQuery& query, Hulls hulls = {}) noexcept;

// --- inside narrow phase

struct PatchView {
  const PairView& pair;
  const Mesh& mesh;
  std::span<const std::uint32_t> triangles;
  Vec3d centre;  // of A, in the mesh's frame

  // `outward`: unit, mesh frame, from the mesh to A.
  void set_normal(Manifold& manifold, const Vec3d& outward) const noexcept {
    manifold.normal = -rotate(pair.world_from_b, outward);
  }
  void add(Manifold& manifold, const Vec3d& mid, double separation, std::uint32_t feature) const noexcept {
    add_point(pair, manifold, pair.b_from_a + rotate(pair.world_from_b, mid), separation, feature);
  }
};

// Feature ids: the kind is in the three top bits.
inline constexpr std::uint32_t kBodyFeature = 0u;              // a corner or end of the body
inline constexpr std::uint32_t kCrossingFeature = 1u << 29;    // an edge of the body crosses an edge of the mesh
inline constexpr std::uint32_t kMeshCornerFeature = 2u << 29;  // a corner of the mesh
inline constexpr std::uint32_t kMeshEdgeFeature = 3u << 29;    // an edge of the mesh
inline constexpr std::uint32_t kEdgePairFeature = 4u << 29;    // an edge of the body against an edge of the mesh

void collide_sphere_patch(const PatchView& patch, Manifold& manifold) noexcept;
void collide_capsule_patch(const PatchView& patch, Manifold& manifold) noexcept;
void collide_hull_patch(const PatchView& patch, const HullView& hull, Manifold& manifold) noexcept;

}  // namespace tactus::physics
