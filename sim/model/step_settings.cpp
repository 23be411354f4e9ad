#include "sim/model/step_settings.h"

#include "sim/model/scene_effects.h"

namespace tactus::sim {

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

}  // namespace tactus::sim
