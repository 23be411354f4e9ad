#include "sim/broad_phase/box_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "rt/base/check.h"
#include "sim/broad_phase/grid_cells.h"

namespace tactus::sim {
namespace {

double power_of_two(int exponent) noexcept {
  return std::bit_cast<double>(static_cast<std::uint64_t>(1023 + exponent) << 52);
}

}  // namespace

BoxGrid::BoxGrid(std::uint32_t max_bodies)
    : entries_(max_bodies), head_(std::bit_ceil(std::max(16u, 2 * max_bodies)), kNone) {
  mask_ = static_cast<std::uint32_t>(head_.size()) - 1;
}

void BoxGrid::insert(std::uint32_t body, const physics::Aabb& box) noexcept {
  TACTUS_CHECK(body < entries_.size() && !entries_[body].inside, body, entries_.size());
  const std::uint32_t level = level_of(box);
  const Cell cell = cell_of(box.lower, level);
  const std::uint32_t bucket = bucket_of(cell, level);
  entries_[body] = {.box = box,
                    .cell = cell,
                    .level = level,
                    .bucket = bucket,
                    .next = head_[bucket],
                    .before = kNone,
                    .inside = true};
  if (head_[bucket] != kNone) entries_[head_[bucket]].before = body;
  head_[bucket] = body;
  ++population_[level];
  ++size_;
}

void BoxGrid::remove(std::uint32_t body) noexcept {
  TACTUS_CHECK(body < entries_.size() && entries_[body].inside, body, entries_.size());
  Entry& entry = entries_[body];
  (entry.before != kNone ? entries_[entry.before].next : head_[entry.bucket]) = entry.next;
  if (entry.next != kNone) entries_[entry.next].before = entry.before;
  entry.inside = false;
  --population_[entry.level];
  --size_;
}

void BoxGrid::clear() noexcept {
  for (Entry& entry : entries_) entry.inside = false;
  std::fill(head_.begin(), head_.end(), kNone);
  population_.fill(0);
  size_ = 0;
}

std::uint64_t BoxGrid::Cells::count() const noexcept {
  const auto side = [](std::int64_t a, std::int64_t b) { return static_cast<std::uint64_t>(b - a + 1); };
  // A side may have 2^41 cells: saturated, so that the product does not overflow.
  const std::uint64_t face =
      std::min(side(low.x, high.x), std::uint64_t{1} << 21) * std::min(side(low.y, high.y), std::uint64_t{1} << 21);
  return face * std::min(side(low.z, high.z), std::uint64_t{1} << 21);
}

std::uint32_t BoxGrid::level_of(const physics::Aabb& box) noexcept {
  const double size = largest_extent(box) / kCellFill;
  if (!std::isfinite(size) || !is_finite(box.lower)) return kTop;
  int exponent = 0;  // size < 2^exponent
  (void)std::frexp(size, &exponent);
  return static_cast<std::uint32_t>(std::clamp(static_cast<int>(kOneMetre) + exponent, 0, static_cast<int>(kTop)));
}

std::int64_t BoxGrid::coordinate(double x_m, std::uint32_t level) noexcept {
  if (level == kTop) return 0;
  return cell_at(x_m * power_of_two(static_cast<int>(kOneMetre) - static_cast<int>(level)));
}

BoxGrid::Cell BoxGrid::cell_of(const Vec3d& corner, std::uint32_t level) noexcept {
  return {coordinate(corner.x, level), coordinate(corner.y, level), coordinate(corner.z, level)};
}

// A box that overlaps this one has its lower corner in the cells under this box or in those just before them.
BoxGrid::Cells BoxGrid::cells_under(const physics::Aabb& box, std::uint32_t level) noexcept {
  if (level == kTop) return {{0, 0, 0}, {0, 0, 0}};
  const Cell low = cell_of(box.lower, level);
  return {{low.x - 1, low.y - 1, low.z - 1}, cell_of(box.upper, level)};
}

std::uint32_t BoxGrid::bucket_of(const Cell& cell, std::uint32_t level) const noexcept {
  const std::uint64_t h = static_cast<std::uint64_t>(cell.x) * 0x9e3779b97f4a7c15ull +
                          static_cast<std::uint64_t>(cell.y) * 0xc2b2ae3d27d4eb4full +
                          static_cast<std::uint64_t>(cell.z) * 0x165667b19e3779f9ull + level * 0x27d4eb2f165667c5ull;
  return static_cast<std::uint32_t>(h >> 32) & mask_;
}

}  // namespace tactus::sim
