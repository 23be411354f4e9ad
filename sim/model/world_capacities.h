// The capacities that the worlds of a scene get. A compound counts as many bodies as it has parts. Thread: [setup].
#pragma once

#include "rt/physics/capacity.h"
#include "sim/model/scene.h"

namespace tactus::sim {

// Of a world with all bodies of the scene: the global world.
physics::Capacities capacities_for(const Scene& scene) noexcept;
// Of a sub-world of that many members, with the scene's fixed bodies and no border contacts.
physics::Capacities member_capacities(const Scene& scene, std::uint32_t members);

}  // namespace tactus::sim
