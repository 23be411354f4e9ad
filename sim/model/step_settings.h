// The step settings that a scene gives to a world of it. Thread: [setup].
#pragma once

#include "rt/physics/step.h"
#include "rt/physics/sweep_precision.h"
#include "sim/model/scene.h"

namespace tactus::sim {

// For steps of `period_s` [s] in `sub_steps` sub-steps.
physics::StepSettings step_settings(const Scene& scene, double period_s, std::uint32_t sub_steps);

// Moving bodies of a scene up to which a global step with ghosts is as fine as the sub-world's ticks, and in double.
inline constexpr std::size_t kMaxBodiesInFineSteps = 200;

// Sub-steps of a global step of `ratio` ticks. With ghosts members have the accuracy of the global step
// (rt/haptics/coupling/border_correction.h); so in a small scene it takes at least the sub-world's
// `haptic_sub_steps` a tick. Where the scene gives far islands fewer sub-steps than others, they keep them.
unsigned global_sub_steps(const Scene& scene, unsigned ratio, unsigned haptic_sub_steps, bool ghosts);

// Precision of the global step's sweeps: `large`, in a scene of more than kMaxBodiesInFineSteps moving bodies; else
// kFull. In single precision an impulse that changes a velocity by less than 6e-8 of it is lost: a plate that rolls on
// a hundred balls at 17 mm/s no longer gains 0.1 mm/s^2 from its slope (tests/border/plate_on_balls.toml).
physics::SweepPrecision sweep_precision(const Scene& scene, physics::SweepPrecision large);

}  // namespace tactus::sim
