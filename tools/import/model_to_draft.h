// A compiled model as a scene's bodies and joints.
//
// Bodies that are held to each other without a joint are one rigid group, and one body of the scene: of one shape, or a
// compound of all that touch, with mass, centre and moments of inertia as MuJoCo has them. What never moves is a body
// for each shape. Units: SI. Frame: world. Thread: any normal one. Bound: that of the model. Errors: all into the
// account.
#pragma once

#include "tools/import/compiled_model.h"
#include "tools/import/mesh_parts.h"

namespace tactus::scene_import {

SceneDraft draft_of(const CompiledModel& model, const PieceOptions& pieces, Account& account);

}  // namespace tactus::scene_import
