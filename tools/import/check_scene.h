// Whether the loader accepts a scene that is not written yet. What it does not accept, such as a mass below 1e-6 kg, is
// refused by the element of the model that it comes from, as all that a scene cannot have.
//
// Thread: any normal one. Bound: the loader's. Errors: a folder for temporary files that cannot be made.
#pragma once

#include "rt/base/status.h"
#include "tools/import/scene_draft.h"

namespace tactus::scene_import {

enum class CheckScope {
  kWhole,
  kElements,  // a scene that lacks what was refused already: mistakes of the model's elements alone
};
// `model`: name of the model's file.
Status check_scene(const SceneFiles& files, const std::string& model, CheckScope scope, Account& account);

}  // namespace tactus::scene_import
