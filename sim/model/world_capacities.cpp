#include "sim/model/world_capacities.h"

#include <algorithm>

namespace tactus::sim {
namespace {

using physics::Body;
using physics::BodyKind;

// A packed cube has 26 neighbours, 13 pairs to each body, and touches 6, 3 contacts to each body: room for 1.2 and 2.7
// times that.
constexpr std::uint32_t kPairsPerBody = 16;
constexpr std::uint32_t kContactsPerBody = 8;
constexpr std::uint32_t kMinPairs = 256;
constexpr std::uint32_t kMinContacts = 256;
// On a mesh: patches near a body, and triangles near a body.
constexpr std::uint32_t kPatchesPerBody = 16;
constexpr std::uint32_t kTrianglesPerBody = 64;

std::uint32_t count_bodies(const Scene& scene, BodyKind kind) noexcept {
  return static_cast<std::uint32_t>(
      std::count_if(scene.bodies.begin(), scene.bodies.end(), [&](const Body& b) { return b.kind == kind; }));
}

// Parts of all bodies that move.
std::uint32_t count_parts(const Scene& scene) noexcept {
  std::uint32_t parts = 0;
  for (const Body& body : scene.bodies)
    if (body.kind == BodyKind::kDynamic) parts += physics::parts_of(body.shape, scene.compounds);
  return parts;
}

}  // namespace

physics::Capacities capacities_for(const Scene& scene) noexcept {
  const std::uint32_t parts = count_parts(scene);
  physics::Capacities capacities{.bodies = count_bodies(scene, BodyKind::kDynamic),
                                 .fixed_bodies = count_bodies(scene, BodyKind::kFixed),
                                 .pairs = std::max(kMinPairs, kPairsPerBody * parts),
                                 .contacts = std::max(kMinContacts, kContactsPerBody * parts),
                                 .border_contacts = 0};
  if (scene.meshes.empty()) return capacities;
  capacities.pairs += kPatchesPerBody * parts;
  capacities.mesh_triangles = kTrianglesPerBody * parts + physics::kMaxBodyTriangles;
  return capacities;
}

}  // namespace tactus::sim
