// A mesh for the real-time side from loose triangles. Thread: [setup]. Units: m. Frame: see physics/mesh.h.
//
// Triangles without area and doubles are left out; neighbours are found, edges judged, flat
// regions gathered into patches (physics/mesh.h says why) and the tree of boxes is built. The same triangles give the
// same mesh. An edge where more than two triangles meet joins those that run on flattest; one whose triangles do not
// agree on what is outside is a boundary. Open edges that lie along others, flat, are joined too (corners in the middle
// of edges), up to some thousands of them. Bound: linear but for sorting; kMaxCornerTriangles at a corner.
#pragma once

#include <memory>

#include "rt/base/result.h"
#include "rt/physics/shapes/mesh.h"
#include "sim/geometry/mesh_files.h"
#include "sim/model/scene.h"

namespace tactus::sim {

// The arrays that a mesh looks into, by the same names.
struct MeshParts {
  std::vector<Vec3d> corners;
  std::vector<physics::MeshTriangle> triangles;
  std::vector<Vec3d> normals;
  std::vector<physics::MeshPatch> patches;
  std::vector<physics::MeshNode> nodes;
  std::vector<std::uint32_t> order, around_start, around;
  Vec3d half_extents;
  BodyId first_patch_id{kNoBody};

  // Valid as long as the parts stay as they are.
  physics::Mesh view() const noexcept {
    return {corners, triangles, normals, patches, nodes, order, around_start, around, half_extents, first_patch_id};
  }
};

struct BuiltMesh {
  std::shared_ptr<const MeshParts> parts;
  physics::Mesh mesh;     // of the parts
  Posed given_from_body;  // where the mesh's frame is in the frame of the corners
  MeshAccount account;    // but for file, body and what was welded
};

// The same triangles with every place once, in the order in which they are used.
TriangleSoup weld(const TriangleSoup& soup);

// Of a soup that is welded. `first_patch_id`: of its patches; the caller's next mesh begins after them. An error says
// what is wrong and what is accepted.
Result<BuiltMesh> build_mesh(const TriangleSoup& soup, BodyId first_patch_id);

// Inside: the tree. Halves the triangles until four are left, across the longest side of their middles' box.
void build_tree(MeshParts& mesh);

}  // namespace tactus::sim
