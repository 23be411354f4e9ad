// Sorts pairs of slots in the order of their keys: each pair once, the lower slot first.
//
// Slots are in the order of ids, so this is the order of PairKey without comparing keys: a counting sort by the higher
// slot, then by the lower one. Thread: construction [setup]; sort [rt], linear in pairs + slots, no allocation.
#pragma once

#include "rt/base/bounded_vector.h"
#include "rt/physics/collision/pair_finder.h"

namespace tactus::physics {

class PairOrder {
 public:
  PairOrder(std::uint32_t slots, std::uint32_t pairs) : begin_(slots + 1), other_(pairs) {}  // [setup] capacities

  // Every slot must be below `slots`. Puts the lower slot first and removes duplicates.
  void sort(BoundedVector<SlotPair>& pairs, std::uint32_t slots) noexcept;

 private:
  template <std::uint32_t SlotPair::*kSlot>
  void sort_by(const BoundedVector<SlotPair>& from, BoundedVector<SlotPair>& to, std::uint32_t slots) noexcept;

  BoundedVector<std::uint32_t> begin_;  // by slot: index of its first pair
  BoundedVector<SlotPair> other_;
};

}  // namespace tactus::physics
