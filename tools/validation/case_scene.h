// Makes a hard case's scene from TOML, with the solver settings of the case in both worlds.
//
// Thread: [setup]. Errors: aborts if the text is not a valid scene, because it is part of the program.
#pragma once

#include <string>

#include "sim/model/scene.h"
#include "tools/validation/hard_case.h"

namespace tactus::hard_cases {

inline constexpr double kMaxForce_N = 30;  // of the device, where the scene names none

sim::Scene case_scene(const std::string& toml, const Setting& setting, double contact_hertz);

}  // namespace tactus::hard_cases
