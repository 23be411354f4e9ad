// Bodies that hang together: the components of a graph whose edges come in any order.
//
// Union-find by the lowest slot, so labels depend on the edges alone. Thread: construction [setup]; the rest: the
// owner [rt], never allocates. Bound: as many bodies as given at construction. Work: all but linear in bodies + edges.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "rt/base/check.h"

namespace tactus::physics {

class Islands {
 public:
  explicit Islands(std::uint32_t max_bodies) : parent_(max_bodies) {}  // [setup]

  // Every body alone.
  void begin(std::uint32_t bodies) noexcept {
    TACTUS_CHECK(bodies <= parent_.size(), bodies, parent_.size());
    for (std::uint32_t slot = 0; slot < bodies; ++slot) parent_[slot] = slot;
  }
  void link(std::uint32_t slot_a, std::uint32_t slot_b) noexcept {
    const std::uint32_t a = of(slot_a), b = of(slot_b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

  // Its island: the lowest slot in it.
  std::uint32_t of(std::uint32_t slot) noexcept {
    while (parent_[slot] != slot) slot = parent_[slot] = parent_[parent_[slot]];
    return slot;
  }

 private:
  std::vector<std::uint32_t> parent_;  // by slot
};

}  // namespace tactus::physics
