// Broad phase by brute force: the pairs of overlapping bounds, for World::dynamic_pairs. Thread: [rt].
#pragma once

#include <span>

#include "rt/base/bounded_vector.h"
#include "rt/physics/shapes/shape.h"

namespace tactus::physics {

// Two slots whose bounds overlap. A pair finder may add them in any order; the world sorts them.
struct SlotPair {
  std::uint32_t a{0}, b{0};
};

// Adds all pairs whose bounds overlap: O(n^2), fixed order. Returns false if not all of them fit; those with the
// highest slots are then missing.
bool find_pairs_brute_force(std::span<const Aabb> bounds, BoundedVector<SlotPair>& pairs) noexcept;

}  // namespace tactus::physics
