#include "tools/validation/case_scene.h"

#include <fmt/format.h>

#include "rt/base/check.h"
#include "sim/loader/scene_load.h"
#include "tools/validation/case_world.h"

namespace tactus::hard_cases {

sim::Scene case_scene(const std::string& toml, const Setting& setting, double contact_hertz) {
  auto parsed = sim::parse_scene(toml, "hard-case");
  if (!parsed.ok()) fmt::print(stderr, "{}\n", parsed.message());
  TACTUS_CHECK(parsed.ok(), toml.size(), 0);
  sim::Scene scene = std::move(parsed).value();
  const auto settings = settings_of(setting, contact_hertz);
  scene.solver.sub_steps = settings.sub_steps;
  scene.solver.relax_sweeps = settings.relax_sweeps;
  scene.solver.global_sub_steps_per_tick = scene.solver.far_sub_steps_per_tick = settings.sub_steps;
  scene.solver.contact_hertz = settings.contact_hertz;
  return scene;
}

}  // namespace tactus::hard_cases
