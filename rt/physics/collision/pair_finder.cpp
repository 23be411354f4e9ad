#include "rt/physics/collision/pair_finder.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "rt/base/wide.h"

namespace tactus::physics {
namespace {

using V = Wide<float, 8>;
constexpr std::uint32_t kWidth = kLanes<V>;
constexpr std::uint32_t kBlock = 1024;  // boxes compared in one block

// Boxes in single precision, one array per coordinate, rounded outward: boxes that do not overlap here do not overlap.
struct Blocks {
  float lower[3][kBlock], upper[3][kBlock];
};

float rounded_down(double value) noexcept {
  constexpr double most = static_cast<double>(std::numeric_limits<float>::max());
  const float f = static_cast<float>(std::clamp(value, -most, most));
  return f - std::abs(f) * std::numeric_limits<float>::epsilon() - std::numeric_limits<float>::min();
}
float rounded_up(double value) noexcept { return -rounded_down(-value); }

// The registers' lanes beyond the last box overlap nothing.
void fill(std::span<const Aabb> bounds, Blocks& blocks) noexcept {
  std::uint32_t i = 0;
  for (; i < bounds.size(); ++i) {
    const Aabb& box = bounds[i];
    blocks.lower[0][i] = rounded_down(box.lower.x);
    blocks.upper[0][i] = rounded_up(box.upper.x);
    blocks.lower[1][i] = rounded_down(box.lower.y);
    blocks.upper[1][i] = rounded_up(box.upper.y);
    blocks.lower[2][i] = rounded_down(box.lower.z);
    blocks.upper[2][i] = rounded_up(box.upper.z);
  }
  for (; i % kWidth != 0; ++i)
    for (int k = 0; k < 3; ++k) {
      blocks.lower[k][i] = std::numeric_limits<float>::infinity();
      blocks.upper[k][i] = -std::numeric_limits<float>::infinity();
    }
}

// Bit k is set where box `a` overlaps box `first` + k.
std::uint32_t overlaps(const Blocks& blocks, std::uint32_t a, std::uint32_t first) noexcept {
  std::uint32_t near = ~0u;
  for (int k = 0; k < 3; ++k) {
    V lower, upper;
    load(lower, &blocks.lower[k][first]);
    load(upper, &blocks.upper[k][first]);
    near &= bits_of(both(V(blocks.lower[k][a]) <= upper, lower <= V(blocks.upper[k][a])));
  }
  return near;
}

bool find_one_by_one(std::span<const Aabb> bounds, BoundedVector<SlotPair>& pairs) noexcept {
  const auto count = static_cast<std::uint32_t>(bounds.size());
  for (std::uint32_t a = 0; a < count; ++a)
    for (std::uint32_t b = a + 1; b < count; ++b)
      if (bounds[a].overlaps(bounds[b]) && !pairs.try_push({a, b})) return false;
  return true;
}

}  // namespace

bool find_pairs_brute_force(std::span<const Aabb> bounds, BoundedVector<SlotPair>& pairs) noexcept {
  const auto count = static_cast<std::uint32_t>(bounds.size());
  if (count > kBlock) return find_one_by_one(bounds, pairs);
  Blocks blocks;
  fill(bounds, blocks);
  for (std::uint32_t a = 0; a + 1 < count; ++a)
    for (std::uint32_t first = (a + 1) / kWidth * kWidth; first < count; first += kWidth) {
      std::uint32_t near = overlaps(blocks, a, first);
      if (first <= a) near &= ~1u << (a - first);  // each pair once
      for (; near != 0; near &= near - 1) {
        const std::uint32_t b = first + static_cast<std::uint32_t>(std::countr_zero(near));
        if (bounds[a].overlaps(bounds[b]) && !pairs.try_push({a, b})) return false;
      }
    }
  return true;
}

}  // namespace tactus::physics
