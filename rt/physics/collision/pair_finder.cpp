#include "rt/physics/collision/pair_finder.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace tactus::physics {
namespace {

constexpr std::uint32_t kBlock = 1024;  // boxes compared in one block
constexpr std::uint32_t kStride = 8;

// Boxes in single precision, one array per coordinate, rounded outward: boxes that do not overlap here do not overlap.
struct Blocks {
  float lower[3][kBlock], upper[3][kBlock];
  std::uint32_t near[kBlock];  // 0: does not overlap the box under test
};

float rounded_down(double value) noexcept {
  constexpr double most = static_cast<double>(std::numeric_limits<float>::max());
  const float f = static_cast<float>(std::clamp(value, -most, most));
  return f - std::abs(f) * std::numeric_limits<float>::epsilon() - std::numeric_limits<float>::min();
}
float rounded_up(double value) noexcept { return -rounded_down(-value); }

void fill(std::span<const Aabb> bounds, Blocks& blocks) noexcept {
  for (std::uint32_t i = 0; i < bounds.size(); ++i) {
    const Aabb& box = bounds[i];
    blocks.lower[0][i] = rounded_down(box.lower.x);
    blocks.upper[0][i] = rounded_up(box.upper.x);
    blocks.lower[1][i] = rounded_down(box.lower.y);
    blocks.upper[1][i] = rounded_up(box.upper.y);
    blocks.lower[2][i] = rounded_down(box.lower.z);
    blocks.upper[2][i] = rounded_up(box.upper.z);
  }
}

// Marks the boxes that box `a` may overlap, from the stride of `first` on; the compiler vectorises the loop.
void mark(Blocks& blocks, std::uint32_t a, std::uint32_t first, std::uint32_t count) noexcept {
  float lower[3], upper[3];
  for (int k = 0; k < 3; ++k) {
    lower[k] = blocks.lower[k][a];
    upper[k] = blocks.upper[k][a];
  }
  const auto &l = blocks.lower, &u = blocks.upper;
  for (std::uint32_t b = first / kStride * kStride; b < count; ++b)
    blocks.near[b] = static_cast<std::uint32_t>(lower[0] <= u[0][b]) & static_cast<std::uint32_t>(l[0][b] <= upper[0]) &
                     static_cast<std::uint32_t>(lower[1] <= u[1][b]) & static_cast<std::uint32_t>(l[1][b] <= upper[1]) &
                     static_cast<std::uint32_t>(lower[2] <= u[2][b]) & static_cast<std::uint32_t>(l[2][b] <= upper[2]);
}

// True if no box of the stride is marked. Entries beyond the last box are zero. Marks at or below
// the first box of a pair cost at most one more test.
bool is_empty(const Blocks& blocks, std::uint32_t stride) noexcept {
  std::uint64_t marks[kStride / 2];
  std::memcpy(marks, blocks.near + stride, sizeof(marks));
  return (marks[0] | marks[1] | marks[2] | marks[3]) == 0;
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
  std::memset(blocks.near, 0, sizeof(blocks.near));
  fill(bounds, blocks);
  for (std::uint32_t a = 0; a + 1 < count; ++a) {
    mark(blocks, a, a + 1, count);
    for (std::uint32_t stride = (a + 1) / kStride * kStride; stride < count; stride += kStride) {
      if (is_empty(blocks, stride)) continue;
      const std::uint32_t end = std::min(stride + kStride, count);
      for (std::uint32_t b = std::max(stride, a + 1); b < end; ++b)
        if (blocks.near[b] != 0 && bounds[a].overlaps(bounds[b]) && !pairs.try_push({a, b})) return false;
    }
  }
  return true;
}

}  // namespace tactus::physics
