// Checks whether the loader accepts a scene that is not written yet. What the loader does not accept, such as a mass
// below 1e-6 kg, is refused with the element of the model that it comes from, as all that a scene cannot have.
//
// Thread: any normal one. Bound: the loader's. Errors: a folder for temporary files that cannot be made.
#pragma once

#include "rt/base/status.h"
#include "tools/import/scene_draft.h"

namespace tactus::scene_import {

enum class CheckScope {
  kWhole,
  kElements,  // checks only errors of model elements; the scene is incomplete because some were refused
};
// `model`: name of the model's file.
Status check_scene(const SceneFiles& files, const std::string& model, CheckScope scope, Account& account);

}  // namespace tactus::scene_import
