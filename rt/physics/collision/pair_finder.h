// Which bodies may touch: pairs of overlapping bounds, for World::dynamic_pairs. Thread: [rt].
#pragma once

#include <span>

#include "rt/base/bounded_vector.h"
#include "rt/physics/shapes/shape.h"

namespace tactus::physics {

// Two slots whose bounds overlap. Filled by a pair finder, in any order; the world sorts.
struct SlotPair {
  std::uint32_t a{0}, b{0};
};

// All pairs of dynamic bodies whose bounds overlap, by brute force: O(n^2), fixed order, no structure. False: there was
// no room for all of them; those with the highest slots are missing.
bool find_pairs_brute_force(std::span<const Aabb> bounds, BoundedVector<SlotPair>& pairs) noexcept;

}  // namespace tactus::physics
