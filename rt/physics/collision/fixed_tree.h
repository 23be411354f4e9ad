// A tree of the bounds of static geometry, which finds the fixed bodies that a box overlaps; distant geometry adds
// little to the work of a step.
//
// The box of an inner node encloses those below it, which are split at the middle of its longest side. Nodes are in
// depth-first order; each has the index of the node at which the search continues if its box is missed, so the search
// needs no stack. Bodies without bounds (planes) are listed separately. Finds exactly the boxes of the brute-force
// test.
// Thread: construction [setup]; build: O(n log n) in bodies, no allocation, by the owner before the first step; find
// [rt]. Frame: world. Units: m. Bound: as many boxes as given at construction.
#pragma once

#include <span>

#include "rt/base/bounded_vector.h"
#include "rt/physics/shapes/shape.h"

namespace tactus::physics {

// The smallest box that encloses both.
inline Aabb join(const Aabb& a, const Aabb& b) noexcept {
  return {{std::min(a.lower.x, b.lower.x), std::min(a.lower.y, b.lower.y), std::min(a.lower.z, b.lower.z)},
          {std::max(a.upper.x, b.upper.x), std::max(a.upper.y, b.upper.y), std::max(a.upper.z, b.upper.z)}};
}

class FixedTree {
 public:
  explicit FixedTree(std::uint32_t capacity) : order_(capacity), unbounded_(capacity), nodes_(2 * capacity) {}

  void build(std::span<const Aabb> bounds) noexcept;  // by slot

  std::span<const std::uint32_t> unbounded() const noexcept { return unbounded_.span(); }  // slots, ascending

  // Calls found(slot) for each overlapping box, in the order of the tree, until it returns false.
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
    std::uint32_t next{0};       // first node after this subtree
    std::uint32_t slot{kInner};  // of a leaf
  };

  void add(std::span<const Aabb> bounds, std::span<std::uint32_t> slots) noexcept;

  BoundedVector<std::uint32_t> order_, unbounded_;
  BoundedVector<Node> nodes_;
};

}  // namespace tactus::physics
