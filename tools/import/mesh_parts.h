// The convex shapes that stand for a mesh that moves: its hull, or the pieces of a concave one.
//
// Units: m. Frame: the mesh's own. Thread: any normal one. Bound: that of pieces.h. Errors and changes: into the
// account.
#pragma once

#include "tools/import/pieces.h"
#include "tools/import/scene_draft.h"

namespace tactus::scene_import {

struct PieceOptions {
  unsigned most{0};           // pieces of a concave mesh, at most physics' kMaxParts; 0, 1: its hull
  double deviation_m{0.001};  // the largest that is wanted
  bool required{true};        // a larger deviation is refused, not only reported
};

// `like`: pose and other fields that every part gets. `label`: name of the mesh in the account. `at`: the place that a
// refusal names; its text is replaced. Returns no part if the mesh is refused.
std::vector<DraftPart> mesh_parts(const sim::TriangleSoup& soup, const PieceOptions& options, const DraftPart& like,
                                  const std::string& label, Refusal at, Account& account);

}  // namespace tactus::scene_import
