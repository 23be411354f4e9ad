// The capacities that the global world of a scene gets. Thread: [setup].
#pragma once

#include "rt/physics/capacity.h"
#include "sim/model/scene.h"

namespace tactus::sim {

// A compound counts as many bodies as it has parts.
physics::Capacities capacities_for(const Scene& scene) noexcept;

}  // namespace tactus::sim
