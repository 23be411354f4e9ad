// The step settings that a scene gives to a world of it. Thread: [setup].
#pragma once

#include "rt/physics/step.h"
#include "sim/model/scene.h"

namespace tactus::sim {

// For steps of `period_s` [s] in `sub_steps` sub-steps.
physics::StepSettings step_settings(const Scene& scene, double period_s, std::uint32_t sub_steps);

}  // namespace tactus::sim
