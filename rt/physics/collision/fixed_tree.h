// Which fixed bodies may a box touch? A tree of boxes over the static geometry, so that the work of a step does not
// grow with geometry that is far away.
//
// Every inner node is the box of what is below it, split at the middle of its longest side; nodes lie in the order of
// a walk from the top, each with the place where the walk goes on when its box is missed: no stack. What has no bounds
// (planes) is listed apart. Exactly the boxes of the brute-force test. Thread: construction [setup]; build: linear
// times logarithm in bodies, no allocation, by the owner before the first step; find [rt]. Frame: world. Units: m.
// Bound: as many boxes as given at construction.
#pragma once

#include <span>

#include "rt/base/bounded_vector.h"
#include "rt/physics/shapes/shape.h"

namespace tactus::physics {

// The smallest box that holds both.
inline Aabb join(const Aabb& a, const Aabb& b) noexcept {
  return {{std::min(a.lower.x, b.lower.x), std::min(a.lower.y, b.lower.y), std::min(a.lower.z, b.lower.z)},
          {std::max(a.upper.x, b.upper.x), std::max(a.upper.y, b.upper.y), std::max(a.upper.z, b.upper.z)}};
}

class FixedTree {
 public:
  explicit FixedTree(std::uint32_t capacity) : order_(capacity), unbounded_(capacity), nodes_(2 * capacity) {}

  void build(std::span<const Aabb> bounds) noexcept;  // by slot

  std::span<const std::uint32_t> unbounded() const noexcept { return unbounded_.span(); }  // slots, ascending

  // Calls found(slot) for each box that overlaps, in an order of the tree's own, until it says false.
  template <class F>
  void find(const Aabb& box, F&& found) const noexcept {
    for (std::uint32_t n = 0; n < nodes_.size();) {
      const Node& node = nodes_[n];
      if (!node.box.overlaps(box)) {
        n = node.next;
        continue;
      }
      if (node.slot != kInner && !found(node.slot)) return;
      ++n;
    }
  }

 private:
  static constexpr std::uint32_t kInner = 0xffffffffu;
  struct Node {
    Aabb box;
    std::uint32_t next{0};       // the node after all that is below this one
    std::uint32_t slot{kInner};  // of a leaf
  };

  void add(std::span<const Aabb> bounds, std::span<std::uint32_t> slots) noexcept;

  BoundedVector<std::uint32_t> order_, unbounded_;
  BoundedVector<Node> nodes_;
};

}  // namespace tactus::physics
