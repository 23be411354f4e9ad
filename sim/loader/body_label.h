// What people call a body of a scene: its name, or its number, and the line of the file that it comes from.
// Thread: [setup]: reads the scene's text again. Bound: the text. Errors: none; of a body that the text does not have,
// the number alone.
#pragma once

#include <string>

#include "sim/model/scene.h"

namespace tactus::sim {

// "the proxy (line 4)", "'door' (line 12)", "body 3 (line 20)", "body 17 (of the [[generate]] of line 30)".
std::string body_label(const Scene& scene, BodyId id);

}  // namespace tactus::sim
