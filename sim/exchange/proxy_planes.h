// The proxy's contacts with anything, as planes for the haptic side (rt/haptics/coupling/plane_coupling.h): what the couplings
// `plane`, `planes` and `linearised` send down in place of members. They travel as border points, whose outside body
// may be a fixed one.
//
// Thread: the global world's; pure. Frame: world. Units: SI. Bound: `most`; of more, those that press most, then the
// nearest, ties by body and feature.
#pragma once

#include "rt/haptics/coupling/snapshot.h"

namespace tactus::sim {

// From the contacts of the world's last step, of `step_s`.
void fill_proxy_planes(const physics::World& world, BodyId proxy, double step_s, std::uint32_t most,
                       FixedVector<haptics::BorderPoint, haptics::kMaxBorderPoints>& planes) noexcept;

}  // namespace tactus::sim
