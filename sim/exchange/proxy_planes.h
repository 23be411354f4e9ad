// The proxy's contacts as planes for the haptic side (rt/haptics/coupling/plane_coupling.h). The couplings `plane`,
// `planes` and `linearised` send them in place of members. They are stored as border points, whose outside body may be
// a fixed one here.
//
// Thread: the global world's; pure. Frame: world. Units: SI. Bound: `most`; of more, those with the largest normal
// force are kept, then the nearest, ties by body, parts and feature.
#pragma once

#include "rt/haptics/coupling/snapshot.h"

namespace tactus::sim {

// Fills `planes` from the contacts of the world's last step, of length `step_s`.
void fill_proxy_planes(const physics::World& world, BodyId proxy, double step_s, std::uint32_t most,
                       FixedVector<haptics::BorderPoint, haptics::kMaxBorderPoints>& planes) noexcept;

}  // namespace tactus::sim
