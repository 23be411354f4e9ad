// The step settings that a scene gives to a world of it. Thread: [setup].
#pragma once

#include "rt/physics/step.h"
#include "rt/physics/sweep_precision.h"
#include "sim/model/scene.h"

namespace tactus::sim {

// Settings for steps of `period_s` [s] in `sub_steps` sub-steps. They have more relax sweeps than the scene gives if
// stacks need them to come to rest (rt/physics/contact/softness.h).
physics::StepSettings step_settings(const Scene& scene, double period_s, std::uint32_t sub_steps);

// The smallest number of sub-steps of a tick of `period_s` [s] that resolves a contact frequency [Hz], which is at most
// a quarter of the sub-step rate: max(1, ceil(4 f T)).
unsigned least_sub_steps(double contact_Hz, double period_s);

// Moving bodies of a scene up to which a global step with ghosts is as fine as the sub-world's ticks, and in double.
inline constexpr std::size_t kMaxBodiesInFineSteps = 200;

// How a global step of `ratio` ticks is divided.
struct GlobalStep {
  unsigned sub_steps{1}, far_sub_steps{1};  // the latter: of islands without a member and out of the proxy's reach
  bool tick_by_tick{false};  // a macro step (rt/physics/macro_steps.h) per tick; else as many as its motion needs
};
// With ghosts members have the accuracy of the global step (rt/haptics/coupling/border_correction.h); so in a small
// scene it is divided as the sub-world's ticks are, each with at least `haptic_sub_steps`. Bodies that nothing connects
// to a member then move as in the direct coupling, bit for bit. In macro steps of several ticks, contacts are found
// later: of 68 random worlds that collapsed, 20 stand with one per tick (tests/border/README.md). Where the scene gives
// far islands fewer sub-steps than others, they have as few, and at least one a macro step.
GlobalStep global_step(const Scene& scene, unsigned ratio, unsigned haptic_sub_steps, bool ghosts);

// Precision of the global step's sweeps: `large`, in a scene of more than kMaxBodiesInFineSteps moving bodies; else
// kFull. In single precision an impulse that changes a velocity by less than 6e-8 of it is lost: a plate that rolls on
// a hundred balls at 17 mm/s no longer gains 0.1 mm/s^2 from its slope (tests/border/plate_on_balls.toml).
physics::SweepPrecision sweep_precision(const Scene& scene, physics::SweepPrecision large);

}  // namespace tactus::sim
