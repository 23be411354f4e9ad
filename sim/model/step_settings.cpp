#include "sim/model/step_settings.h"

#include <algorithm>

#include "sim/model/scene_effects.h"

namespace tactus::sim {
namespace {

bool is_small(const Scene& scene) {
  const auto moving = std::count_if(scene.bodies.begin(), scene.bodies.end(),
                                    [](const physics::Body& body) { return body.kind != physics::BodyKind::kFixed; });
  return static_cast<std::size_t>(moving) <= kMaxBodiesInFineSteps;
}

}  // namespace

physics::StepSettings step_settings(const Scene& scene, double period_s, std::uint32_t sub_steps) {
  physics::StepSettings settings;
  settings.dt = period_s;
  settings.sub_steps = sub_steps;
  settings.contact_hertz = scene.solver.contact_hertz;
  settings.relax_sweeps = scene.solver.relax_sweeps;
  settings.friction_sweeps = scene.solver.friction_sweeps;
  settings.contact_damping_ratio = scene.solver.contact_damping_ratio;
  choose_effects(scene, settings);
  return settings;
}

unsigned global_sub_steps(const Scene& scene, unsigned ratio, unsigned haptic_sub_steps, bool ghosts) {
  const unsigned asked = scene.solver.global_sub_steps(ratio);
  return ghosts && is_small(scene) ? std::max(asked, ratio * haptic_sub_steps) : asked;
}

physics::SweepPrecision sweep_precision(const Scene& scene, physics::SweepPrecision large) {
  return is_small(scene) ? physics::SweepPrecision::kFull : large;
}

}  // namespace tactus::sim
