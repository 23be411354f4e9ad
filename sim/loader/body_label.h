// A label for a body of a scene, for messages: its name or number, and its line in the file.
// Thread: [setup]. Bound: the generated parts. Errors: none; a body that is not in the file gets the number only.
#pragma once

#include <string>

#include "sim/model/scene.h"

namespace tactus::sim {

// "the proxy (line 4)", "'door' (line 12)", "body 3 (line 20)", "body 17 (of the [[generate]] of line 30)".
std::string body_label(const Scene& scene, BodyId id);

}  // namespace tactus::sim
