#include "sim/model/step_settings.h"

#include <algorithm>
#include <cmath>

#include "rt/physics/contact/softness.h"
#include "sim/model/scene_effects.h"

namespace tactus::sim {
namespace {

bool is_small(const Scene& scene) { return scene.moving_bodies() <= kMaxBodiesInFineSteps; }

}  // namespace

physics::StepSettings step_settings(const Scene& scene, double period_s, std::uint32_t sub_steps) {
  physics::StepSettings settings;
  settings.dt = period_s;
  settings.sub_steps = sub_steps;
  settings.contact_hertz = scene.solver.contact_hertz;
  settings.relax_sweeps = std::max(
      scene.solver.relax_sweeps, physics::least_relax_sweeps(settings.contact_hertz, settings.dt / settings.sub_steps));
  settings.friction_sweeps = scene.solver.friction_sweeps;
  settings.contact_damping_ratio = scene.solver.contact_damping_ratio;
  choose_effects(scene, settings);
  return settings;
}

unsigned least_sub_steps(double contact_Hz, double period_s) {
  return std::max(1u, static_cast<unsigned>(std::ceil(4.0 * contact_Hz * period_s - 1e-9)));
}

GlobalStep global_step(const Scene& scene, unsigned ratio, unsigned haptic_sub_steps, bool ghosts) {
  const unsigned asked = scene.solver.global_sub_steps(ratio);
  GlobalStep step{.sub_steps = asked, .tick_by_tick = ghosts && is_small(scene)};
  if (step.tick_by_tick) step.sub_steps = ratio * std::max(haptic_sub_steps, (asked + ratio - 1) / ratio);
  // Unless the scene asks for fewer, far islands have as many: one that changes between the two would creep.
  step.far_sub_steps = step.sub_steps;
  const double far = scene.solver.far_sub_steps_per_tick;
  if (far > 0 && far < scene.solver.global_sub_steps_per_tick) {
    step.far_sub_steps = scene.solver.far_sub_steps(ratio);
    if (step.tick_by_tick) step.far_sub_steps = ratio * std::max(1u, step.far_sub_steps / ratio);
  }
  return step;
}

physics::SweepPrecision sweep_precision(const Scene& scene, physics::SweepPrecision large) {
  return is_small(scene) ? physics::SweepPrecision::kFull : large;
}

}  // namespace tactus::sim
