// The capacities of a world, given once at creation, and the bits that report which of them was exceeded.
//
// Overflow is not an error: the step leaves out what does not fit, by the rule beside each capacity, sets the bit and
// counts what it left out. Thread: [any].
#pragma once

#include <cstdint>

namespace tactus::physics {

struct Capacities {
  std::uint32_t bodies{256};       // dynamic bodies; beyond: `insert` refuses
  std::uint32_t fixed_bodies{64};  // static geometry; beyond: `insert` refuses
  std::uint32_t pairs{2048};    // overlapping boxes; beyond: pairs of moving bodies with the highest keys are dropped
  std::uint32_t contacts{512};  // manifolds; beyond: the deepest are kept, ties by lower pair key
  std::uint32_t border_contacts{0};  // contacts with bodies of another world; beyond: `add` refuses
  std::uint32_t mesh_triangles{
      0};  // near moving bodies, in one step; beyond: those of the highest body ids are dropped
};

// Explicit numbers, never reused.
enum CapacityBit : std::uint32_t {
  kBodiesFull = 1u << 0,
  kFixedBodiesFull = 1u << 1,
  kPairsFull = 1u << 2,
  kContactsFull = 1u << 3,
  kBorderContactsFull = 1u << 4,
  kMeshTrianglesFull = 1u << 5,  // also where a body can touch more than kMaxBodyTriangles: the nearest are kept
};

}  // namespace tactus::physics
