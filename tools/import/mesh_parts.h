// The convex shapes that stand for a mesh that moves: its hull, or the pieces of a concave one.
//
// Units: m. Frame: the mesh's own. Thread: any normal one. Bound: that of pieces.h. Errors and changes: into the
// account.
#pragma once

#include "tools/import/pieces.h"
#include "tools/import/scene_draft.h"

namespace tactus::scene_import {

struct PieceOptions {
  unsigned most{0};           // pieces of a concave mesh, at most physics' kMaxParts; 0: its hull
  double deviation_m{0.001};  // largest that is accepted
};

// `like`: what every part has, its pose above all. `label`: of the mesh, in the account. `at`: where a refusal points;
// its text is replaced. None where it is refused.
std::vector<DraftPart> mesh_parts(const sim::TriangleSoup& soup, const PieceOptions& options, const DraftPart& like,
                                  const std::string& label, Refusal at, Account& account);

}  // namespace tactus::scene_import
