// Builds a mesh for the real-time side from a triangle soup. Thread: [setup]. Units: m. Frame: see physics/mesh.h.
//
// Triangles without area and duplicates are left out. Then neighbours are found, edges classified, flat regions
// gathered into patches (for the reason see physics/mesh.h) and the tree of boxes is built. The same triangles give the
// same mesh. At an edge of more than two triangles, the pairs with the smallest fold are joined. An edge whose two
// triangles have opposite orientations is a boundary. Open edges that lie along others and are flat are joined too
// (T-junctions), if the mesh has at most some thousands of open edges. Bound: linear but for sorting;
// kMaxCornerTriangles at a corner.
#pragma once

#include <memory>

#include "rt/base/result.h"
#include "rt/physics/shapes/mesh.h"
#include "sim/geometry/mesh_files.h"
#include "sim/model/scene.h"

namespace tactus::sim {

// Owns the arrays that a physics::Mesh refers to, under the same names.
struct MeshParts {
  std::vector<Vec3d> corners;
  std::vector<physics::MeshTriangle> triangles;
  std::vector<Vec3d> normals;
  std::vector<physics::MeshPatch> patches;
  std::vector<physics::MeshNode> nodes;
  std::vector<std::uint32_t> order, around_start, around;
  Vec3d half_extents;
  BodyId first_patch_id{kNoBody};

  // Valid until the parts change.
  physics::Mesh view() const noexcept {
    return {.corners = corners,
            .triangles = triangles,
            .normals = normals,
            .patches = patches,
            .nodes = nodes,
            .order = order,
            .around_start = around_start,
            .around = around,
            .half_extents = half_extents,
            .first_patch_id = first_patch_id};
  }
};

struct BuiltMesh {
  std::shared_ptr<const MeshParts> parts;
  physics::Mesh mesh;     // view of the parts
  Posed given_from_body;  // pose of the mesh's frame in the frame of the corners
  MeshAccount account;    // without file, body and welded
};

// Merges corners at the same position; corners are in the order of first use.
TriangleSoup weld(const TriangleSoup& soup);

// `soup` must be welded. `first_patch_id`: id of its first patch; the caller's next mesh starts after its last. An
// error says what is wrong and what is accepted.
Result<BuiltMesh> build_mesh(const TriangleSoup& soup, BodyId first_patch_id);

// Internal: builds the tree of boxes. Splits the triangles in half, along the longest side of the box of their
// centroids, until at most four are left.
void build_tree(MeshParts& mesh);

}  // namespace tactus::sim
