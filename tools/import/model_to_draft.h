// A compiled model as a scene's bodies and joints.
//
// Bodies that are held to each other without a joint are one rigid group. A group with one shape that touches is one
// body, with mass, centre and moments of inertia as MuJoCo has them. A group of several is a body for each shape, held
// to the heaviest by fixed joints: together they have the mass, the centre and the moments. Units: SI. Frame: world.
// Thread: any normal one. Bound: that of the model. Errors: all into the account.
#pragma once

#include "tools/import/compiled_model.h"
#include "tools/import/scene_draft.h"

namespace tactus::scene_import {

struct PieceOptions {
  unsigned most{0};           // pieces of a concave mesh; 0: its hull
  double deviation_m{0.001};  // largest that is accepted
};

SceneDraft draft_of(const CompiledModel& model, const PieceOptions& pieces, Account& account);

}  // namespace tactus::scene_import
