// A mesh for the real-time side from loose triangles. Thread: [setup]. Units: m. Frame: see physics/mesh.h.
//
// Triangles without area and doubles are left out; neighbours are found, edges judged, flat
// regions gathered into patches (physics/mesh.h says why) and the tree of boxes is built. The same triangles give the
// same mesh. An edge where more than two triangles meet joins those that run on flattest; one whose triangles do not
// agree on what is outside is a boundary. Bound: linear but for sorting; kMaxCornerTriangles at a corner.
#pragma once

#include "rt/base/result.h"
#include "rt/physics/mesh.h"
#include "sim/mesh_files.h"
#include "sim/scene.h"

namespace tactus::sim {

struct BuiltMesh {
  physics::Mesh<double> mesh;
  Posed given_from_body;  // where the mesh's frame is in the frame of the corners
  MeshAccount account;    // but for file, body and what was welded
};

// The same triangles with every place once, in the order in which they are used.
TriangleSoup weld(const TriangleSoup& soup);

// Of a soup that is welded. `first_patch_id`: of its patches; the caller's next mesh begins after them. An error says
// what is wrong and what is accepted.
Result<BuiltMesh> build_mesh(const TriangleSoup& soup, BodyId first_patch_id);

// Inside: the tree. Halves the triangles until four are left, across the longest side of their middles' box.
void build_tree(physics::Mesh<double>& mesh);

}  // namespace tactus::sim
