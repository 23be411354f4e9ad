// The first message of a page: one JSON object with the scene's shapes and bodies, what was run, and the channels.
//
// "shapes": each once; "bodies": by id, with shape, pose [m; quaternion w x y z] and whether it is fixed. Pure. Thread:
// any normal one. Bound: linear in the bodies and in the corners of hulls and meshes.
#pragma once

#include <string>

#include "sim/model/scene.h"
#include "tools/session/run_options.h"

namespace tactus::view {

std::string scene_text(const sim::Scene& scene, const session::TapeSettings& settings);

}  // namespace tactus::view
