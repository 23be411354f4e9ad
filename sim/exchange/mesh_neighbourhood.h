// The triangles of meshes that members of a sub-world may touch before the next snapshot: they travel with it.
//
// Each member has a region for each mesh near it: its box, grown by what it can move until the snapshot after the next
// is adopted (boundary_cube.h). A member without a region, or beyond it, asks the mesh's tree by itself: what does not
// fit costs the haptic thread time, nothing else. Thread: the global world's. Units: m.
// Bound: the snapshot's capacities; a region of more than kMaxBodyTriangles is left out. What does not fit is counted.
#pragma once

#include "rt/haptics/coupling/snapshot.h"
#include "sim/exchange/boundary_cube.h"

namespace tactus::sim {

// `members` and `proxy`: places in `bodies`.
void fill_near_triangles(std::span<const physics::Body> bodies, std::span<const physics::Body> fixed_bodies,
                         physics::Meshes meshes, std::span<const std::uint32_t> members, std::uint32_t proxy,
                         const ReachSettings& reach, haptics::WorldSnapshot& next) noexcept;

}  // namespace tactus::sim
