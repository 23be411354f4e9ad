// Islands: the connected components of a graph of bodies, whose edges are added in any order.
//
// Union-find by the lowest slot, so labels depend only on the edges. A view: the owner provides the storage.
// Thread: the owner's [rt]; never allocates. Bound: nearly linear in bodies + edges.
#pragma once

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <span>

namespace tactus::physics {

class Islands {
 public:
  Islands() = default;
  // Makes every body an island of its own. `storage`: one entry per body.
  explicit Islands(std::span<std::uint32_t> storage) noexcept : parent_(storage) {
    std::iota(storage.begin(), storage.end(), 0u);
  }

  void link(std::uint32_t slot_a, std::uint32_t slot_b) noexcept {
    const std::uint32_t a = of(slot_a), b = of(slot_b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

  // Label of the body's island: the lowest slot in it.
  std::uint32_t of(std::uint32_t slot) noexcept {
    while (parent_[slot] != slot) slot = parent_[slot] = parent_[parent_[slot]];
    return slot;
  }

 private:
  std::span<std::uint32_t> parent_;  // by slot
};

}  // namespace tactus::physics
