// Collects the mesh triangles that members of a sub-world may touch before the next snapshot; the snapshot carries
// them.
//
// Each member has a region for each mesh near it: its box, grown by its possible motion until the snapshot after the
// next is imported (boundary_cube.h). For a member without a region, or outside it, the haptic thread searches the
// mesh's tree: entries that do not fit cost that thread time, nothing else.
// Thread: the global world's. Units: m. Bound: the snapshot's capacities; a region of more than kMaxBodyTriangles is
// left out. What does not fit is counted.
#pragma once

#include "rt/haptics/coupling/snapshot.h"
#include "sim/exchange/boundary_cube.h"

namespace tactus::sim {

// The members of a sub-world; the proxy is one of them.
struct SubWorldBodies {
  BodySpan<const physics::Body> bodies;
  std::span<const BodyIndex> members;
  BodyIndex proxy;
};

void fill_near_triangles(const SubWorldBodies& sub_world, std::span<const physics::Body> fixed_bodies,
                         physics::Meshes meshes, const ReachSettings& reach, haptics::WorldSnapshot& next) noexcept;

}  // namespace tactus::sim
