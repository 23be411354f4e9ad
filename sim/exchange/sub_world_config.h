// The configuration of a haptic sub-world of a scene, for the haptic side and for the global world's prediction of it.
// Thread: [setup].
#pragma once

#include "rt/haptics/coupling/sub_world.h"
#include "sim/model/scene.h"

namespace tactus::sim {

// The choices of a run that determine its sub-world.
struct SubWorldChoice {
  haptics::CouplingScheme coupling;
  physics::BorderMode border;
  BodyId proxy;
  std::uint32_t ratio;
  double tick_period_s;
  std::uint32_t sub_steps;  // in a tick
  std::uint32_t members;    // at most
  haptics::CouplingGains gains;
};

// The scene must outlive the sub-world.
haptics::SubWorldConfig sub_world_config(const Scene& scene, const SubWorldChoice& choice);

// The scene's fixed bodies, the sub-world's static geometry.
std::vector<physics::Body> fixed_bodies_of(const Scene& scene);

}  // namespace tactus::sim
