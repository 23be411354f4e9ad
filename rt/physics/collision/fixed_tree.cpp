#include "rt/physics/collision/fixed_tree.h"

#include <algorithm>

namespace tactus::physics {
namespace {

// The axis of the box's longest side.
double Vec3d::*longest_side(const Aabb& box) noexcept {
  const Vec3d e = box.upper - box.lower;
  if (e.x >= e.y && e.x >= e.z) return &Vec3d::x;
  return e.y >= e.z ? &Vec3d::y : &Vec3d::z;
}

}  // namespace

void FixedTree::build(std::span<const Aabb> bounds) noexcept {
  order_.clear();
  unbounded_.clear();
  nodes_.clear();
  for (std::uint32_t slot = 0; slot < bounds.size(); ++slot) {
    const bool bounded = is_finite(bounds[slot].lower) && is_finite(bounds[slot].upper);
    TACTUS_CHECK((bounded ? order_ : unbounded_).try_push(slot), slot, order_.capacity());
  }
  if (!order_.empty()) add(bounds, order_.span());
}

// Adds the subtree of these slots. Recursion depth: logarithm of their number.
void FixedTree::add(std::span<const Aabb> bounds, std::span<std::uint32_t> slots) noexcept {
  Aabb box = bounds[slots[0]];
  for (const std::uint32_t slot : slots) box = join(box, bounds[slot]);
  const std::uint32_t node = nodes_.size();
  TACTUS_CHECK(nodes_.try_push({box}), node, nodes_.capacity());
  if (slots.size() == 1) {
    nodes_[node].slot = slots[0];
  } else {
    double Vec3d::*const axis = longest_side(box);
    const auto middle = [&](std::uint32_t slot) { return bounds[slot].lower.*axis + bounds[slot].upper.*axis; };
    const std::size_t half = slots.size() / 2;
    std::nth_element(
        slots.begin(), slots.begin() + static_cast<std::ptrdiff_t>(half), slots.end(),
        [&](std::uint32_t a, std::uint32_t b) { return middle(a) != middle(b) ? middle(a) < middle(b) : a < b; });
    add(bounds, slots.first(half));
    add(bounds, slots.subspan(half));
  }
  nodes_[node].next = nodes_.size();
}

}  // namespace tactus::physics
