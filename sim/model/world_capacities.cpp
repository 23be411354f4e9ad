#include "sim/model/world_capacities.h"

#include <algorithm>
#include <functional>
#include <numeric>
#include <vector>

namespace tactus::sim {
namespace {

using physics::Body;
using physics::BodyKind;

// In a dense packing a cube has 26 neighbours (13 pairs per body) and touches 6 of them (3 contacts per body). The
// capacities are 1.2 and 2.7 times that. A sub-world has more, because its members may have the most neighbours.
constexpr std::uint32_t kPairsPerBody = 16;
constexpr std::uint32_t kContactsPerBody = 8;
constexpr std::uint32_t kContactsPerMember = 10;
constexpr std::uint32_t kMorePairs = 64;  // for a sub-world of few members
constexpr std::uint32_t kMoreContacts = 32;
constexpr std::uint32_t kMinPairs = 256;
constexpr std::uint32_t kMinContacts = 256;
// On a mesh: patches near a body, and triangles near a body.
constexpr std::uint32_t kPatchesPerBody = 16;
constexpr std::uint32_t kTrianglesPerBody = 64;
// Room for that many bodies on a mesh so fine that each has all the triangles that a body may have.
constexpr std::uint32_t kBodiesOnFineMesh = 256;

std::uint32_t fixed_bodies(const Scene& scene) noexcept {
  return static_cast<std::uint32_t>(scene.bodies.size()) - scene.moving_bodies();
}

// Parts of all bodies that move.
std::uint32_t count_parts(const Scene& scene) noexcept {
  std::uint32_t parts = 0;
  for (const Body& body : scene.bodies)
    if (body.kind == BodyKind::kDynamic) parts += physics::parts_of(body.shape, scene.compounds);
  return parts;
}

// The parts of that many bodies, those with the most parts.
std::uint32_t most_parts(const Scene& scene, std::uint32_t members) {
  std::vector<std::uint32_t> parts;
  for (const Body& body : scene.bodies)
    if (body.kind == BodyKind::kDynamic) parts.push_back(physics::parts_of(body.shape, scene.compounds));
  std::sort(parts.begin(), parts.end(), std::greater<>());
  if (parts.size() < members) parts.resize(members, 1);
  return std::accumulate(parts.begin(), parts.begin() + members, 0u);
}

// For bodies of that many parts on meshes.
void add_meshes(const Scene& scene, std::uint32_t parts, physics::Capacities& capacities) noexcept {
  if (scene.meshes.empty()) return;
  capacities.pairs += kPatchesPerBody * parts;
  capacities.mesh_triangles =
      kTrianglesPerBody * parts + physics::kMaxBodyTriangles * std::min(parts + 1, kBodiesOnFineMesh);
}

}  // namespace

physics::Capacities capacities_for(const Scene& scene) noexcept {
  const std::uint32_t parts = count_parts(scene);
  physics::Capacities capacities{.bodies = scene.moving_bodies(),
                                 .fixed_bodies = fixed_bodies(scene),
                                 .pairs = std::max(kMinPairs, kPairsPerBody * parts),
                                 .contacts = std::max(kMinContacts, kContactsPerBody * parts),
                                 .border_contacts = 0};
  add_meshes(scene, parts, capacities);
  return capacities;
}

physics::Capacities member_capacities(const Scene& scene, std::uint32_t members) {
  const std::uint32_t parts = most_parts(scene, members);
  physics::Capacities capacities{.bodies = members,
                                 .fixed_bodies = std::max(1u, fixed_bodies(scene)),
                                 .pairs = kPairsPerBody * parts + kMorePairs,
                                 .contacts = kContactsPerMember * parts + kMoreContacts,
                                 .border_contacts = 0};
  add_meshes(scene, parts, capacities);
  return capacities;
}

}  // namespace tactus::sim
