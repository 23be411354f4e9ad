// A hard case's scene, from TOML, with the solver of its setting in both worlds. [setup] Aborts where the text is no
// scene: it is the program's own.
#pragma once

#include <string>

#include "sim/model/scene.h"
#include "tools/validation/hard_case.h"

namespace tactus::hard_cases {

sim::Scene case_scene(const std::string& toml, const Setting& setting, double contact_hertz);

}  // namespace tactus::hard_cases
