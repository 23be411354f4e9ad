#include "sim/exchange/sub_world_config.h"

#include <algorithm>
#include <iterator>

#include "sim/model/scene_effects.h"
#include "sim/model/step_settings.h"
#include "sim/model/world_capacities.h"

namespace tactus::sim {

haptics::SubWorldConfig sub_world_config(const Scene& scene, const SubWorldChoice& choice) {
  haptics::SubWorldConfig config;
  config.scheme = choice.coupling;
  config.border_mode = choice.border;
  config.ratio = choice.ratio;
  config.proxy = choice.proxy;
  config.step = step_settings(scene, choice.tick_period_s, choice.sub_steps);
  config.gains = choice.gains;
  config.shapes = scene.shapes();
  config.effects = effect_setups(scene);
  config.capacities = member_capacities(scene, choice.members);
  config.capacities.border_contacts = haptics::kMaxBorderPoints;
  return config;
}

std::vector<physics::Body> fixed_bodies_of(const Scene& scene) {
  std::vector<physics::Body> fixed;
  std::copy_if(scene.bodies.begin(), scene.bodies.end(), std::back_inserter(fixed),
               [](const physics::Body& body) { return body.kind == physics::BodyKind::kFixed; });
  return fixed;
}

}  // namespace tactus::sim
