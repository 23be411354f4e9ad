#include "sim/broad_phase/pair_grid.h"

#include <bit>
#include <cmath>

#include "sim/broad_phase/grid_cells.h"

namespace tactus::sim {
namespace {

// The k with 2^(k-1) <= x < 2^k; -1000 or 1000 for numbers without one.
int power_above(double x) noexcept {
  if (!(x > 0)) return -1000;
  if (!std::isfinite(x)) return 1000;
  int exponent = 0;
  (void)std::frexp(x, &exponent);
  return exponent;
}

}  // namespace

PairGrid::PairGrid(std::uint32_t max_bodies)
    : entries_(max_bodies),
      bucket_(max_bodies),
      level_(max_bodies),
      start_(std::bit_ceil(std::max(16u, 2 * max_bodies)) + 1),
      mask_(static_cast<std::uint32_t>(start_.size()) - 2) {}

void PairGrid::share_work(const physics::Executor& executor, std::uint32_t parts, std::uint32_t max_pairs) {
  executor_ = executor;
  parts_ = std::vector<Part>(parts > 1 ? parts : 0);
  for (Part& part : parts_) part.pairs = BoundedVector<physics::SlotPair>(max_pairs);
}

bool PairGrid::find(std::span<const physics::Aabb> bounds, BoundedVector<physics::SlotPair>& pairs) noexcept {
  TACTUS_CHECK(bounds.size() <= entries_.size(), bounds.size(), entries_.size());
  work_ = {};
  count_ = static_cast<std::uint32_t>(bounds.size());
  if (count_ < 2) return true;
  // As many buckets as these boxes need: within the allocated capacity.
  start_.resize(std::bit_ceil(std::max(16u, 2 * count_)) + 1);
  mask_ = static_cast<std::uint32_t>(start_.size()) - 2;
  choose_levels(bounds);
  fill_table(bounds);
  if (!parts_.empty()) return find_in_parts(pairs);
  Found found{pairs, {}};
  const bool all = find_from(0, count_, found);
  work_ = found.work;
  return all;
}

bool PairGrid::find_from(std::uint32_t begin, std::uint32_t end, Found& found) const noexcept {
  bool all = true;
  for (std::uint32_t i = begin; i < end && all; ++i) {
    all = find_on_own_level(i, found);
    for (std::uint32_t level = entries_[i].level + 1; level <= coarsest_ && all; ++level)
      if (population_[level] > 0) all = find_on_coarser_level(i, level, found);
  }
  return all;
}

// The parts are appended in order, so that the pairs, and those left out, are the same as without an executor.
bool PairGrid::find_in_parts(BoundedVector<physics::SlotPair>& pairs) noexcept {
  const auto parts = static_cast<std::uint32_t>(parts_.size());
  executor_.for_each_range(parts, 1, [&](std::uint32_t p, std::uint32_t end) noexcept {
    for (; p < end; ++p) {
      Part& part = parts_[p];
      part.pairs.clear();
      Found found{part.pairs, {}};
      const auto start = [&](std::uint64_t k) { return static_cast<std::uint32_t>(k * count_ / parts); };
      part.all = find_from(start(p), start(p + 1), found);
      part.work = found.work;
    }
  });
  for (const Part& part : parts_) {
    work_.box_tests += part.work.box_tests;
    work_.rows += part.work.rows;
    for (const physics::SlotPair& pair : part.pairs)
      if (!pairs.try_push(pair)) return false;
    if (!part.all) return false;
  }
  return true;
}

// The base cell just fits the largest box in the most frequent octave of sizes, whose start is free. So a world of
// equal bodies, in any orientation, has one level, and its cells are little larger than the boxes.
void PairGrid::choose_levels(std::span<const physics::Aabb> bounds) noexcept {
  // A histogram by quarters of an octave: the power of two above the fourth power of the extent.
  constexpr int kQuarters = 512, kOctave = 4;
  std::array<std::uint32_t, kQuarters> histogram{};
  std::array<double, kQuarters> largest{};
  for (const auto& box : bounds) {
    const double extent = largest_extent(box), square = extent * extent;
    const auto quarter =
        static_cast<std::uint32_t>(std::clamp(power_above(square * square) + kQuarters / 2, 0, kQuarters - 1));
    ++histogram[quarter];
    largest[quarter] = std::max(largest[quarter], extent);
  }
  std::uint32_t in_octave = 0, most = 0;
  double size = 0;
  for (std::size_t end = 0; end < kQuarters; ++end) {
    in_octave += histogram[end] - (end < kOctave ? 0 : histogram[end - kOctave]);
    if (in_octave <= most) continue;
    most = in_octave;
    size = *std::max_element(largest.begin() + (end < kOctave ? 0 : end - kOctave + 1), largest.begin() + end + 1);
  }
  base_cell_m_ = size > 0 && std::isfinite(size) ? size * 1.0001 / kCellFill : 1.0;
  for (int level = 0; level < kLevels; ++level)
    cells_per_m_[static_cast<std::size_t>(level)] = std::ldexp(1.0 / base_cell_m_, kBaseLevel - level);
}

void PairGrid::fill_table(std::span<const physics::Aabb> bounds) noexcept {
  std::fill(start_.begin(), start_.end(), 0u);
  population_.fill(0);
  coarsest_ = 0;
  for (std::uint32_t body = 0; body < count_; ++body) {
    const auto box = bounds[body];
    const auto level = static_cast<std::uint32_t>(level_of(box));
    level_[body] = level;
    bucket_[body] = bucket_of(cell_of(box.lower, level), level);
    ++population_[level];
    coarsest_ = std::max(coarsest_, level);
    ++start_[bucket_[body] + 1];
  }
  for (std::size_t b = 1; b < start_.size(); ++b) start_[b] += start_[b - 1];
  // Filled backwards, each bucket from its end: bodies of a bucket keep their order, and the table of ends, shifted by
  // one, becomes the table of starts.
  for (std::uint32_t body = count_; body-- > 0;) {
    Entry& entry = entries_[--start_[bucket_[body] + 1]];
    const auto box = bounds[body];
    entry = {.box = box, .cell = cell_of(box.lower, level_[body]), .body = body, .level = level_[body]};
  }
  for (std::size_t b = 0; b + 1 < start_.size(); ++b) start_[b] = start_[b + 1];
  start_.back() = count_;
}

int PairGrid::level_of(const physics::Aabb& box) const noexcept {
  if (!is_finite(box.lower) || !is_finite(box.upper)) return kTopLevel;
  return std::clamp(kBaseLevel + power_above(largest_extent(box) / (kCellFill * base_cell_m_)), 0, kTopLevel);
}

std::int64_t PairGrid::coordinate(double x_m, std::uint32_t level) const noexcept {
  if (level == kTopLevel) return 0;
  return cell_at(x_m * cells_per_m_[level]);
}

PairGrid::Cell PairGrid::cell_of(const Vec3d& corner, std::uint32_t level) const noexcept {
  return {coordinate(corner.x, level), coordinate(corner.y, level), coordinate(corner.z, level)};
}

// Cells adjacent in x have adjacent buckets, so that a row of cells is one run of entries.
std::uint32_t PairGrid::bucket_of(const Cell& cell, std::uint32_t level) const noexcept {
  const std::uint64_t h = static_cast<std::uint64_t>(cell.x) + static_cast<std::uint64_t>(cell.y) * 0x9e3779b1u +
                          static_cast<std::uint64_t>(cell.z) * 0x85ebca77u + level * 0xc2b2ae3du;
  return static_cast<std::uint32_t>(h) & mask_;
}

// Searches half of the neighbourhood: later boxes of the own cell, and the 13 cells that follow it. Boxes in the other
// 13 cells find this one.
bool PairGrid::find_on_own_level(std::uint32_t index, Found& found) const noexcept {
  const Entry& entry = entries_[index];
  const Cell& c = entry.cell;
  const std::uint32_t bucket = bucket_of(c, entry.level);
  if (!scan_entries(entry, {.level = entry.level, .first = c, .cells = 1}, index + 1, start_[bucket + 1], found))
    return false;
  if (entry.level == kTopLevel) return true;
  const auto scan = [&](const Cell& first, std::uint32_t cells) noexcept {
    return scan_row(entry, {.level = entry.level, .first = first, .cells = cells}, found);
  };
  if (!scan({c.x + 1, c.y, c.z}, 1)) return false;
  if (!scan({c.x - 1, c.y + 1, c.z}, 3)) return false;
  for (std::int64_t y = c.y - 1; y <= c.y + 1; ++y)
    if (!scan({c.x - 1, y, c.z + 1}, 3)) return false;
  return true;
}

// A larger box that overlaps this one has its lower corner in the cells under this box or in those just before them.
bool PairGrid::find_on_coarser_level(std::uint32_t index, std::uint32_t level, Found& found) const noexcept {
  const Entry& entry = entries_[index];
  if (level == kTopLevel) return scan_row(entry, {.level = level, .first = {0, 0, 0}, .cells = 1}, found);
  const Cell low = cell_of(entry.box.lower, level), high = cell_of(entry.box.upper, level);
  const auto width = static_cast<std::uint32_t>(std::clamp<std::int64_t>(high.x - low.x + 2, 0, 4));
  for (std::int64_t z = low.z - 1; z <= high.z; ++z)
    for (std::int64_t y = low.y - 1; y <= high.y; ++y)
      if (!scan_row(entry, {.level = level, .first = {low.x - 1, y, z}, .cells = width}, found)) return false;
  return true;
}

// The cells of a row are one run of buckets, or two at the end of the table.
bool PairGrid::scan_row(const Entry& entry, const CellRow& row, Found& found) const noexcept {
  ++found.work.rows;
  const std::uint32_t bucket = bucket_of(row.first, row.level), buckets = mask_ + 1;
  const std::uint32_t before_end = std::min(row.cells, buckets - bucket);
  if (!scan_entries(entry, row, start_[bucket], start_[bucket + before_end], found)) return false;
  return before_end == row.cells || scan_entries(entry, row, start_[0], start_[row.cells - before_end], found);
}

// Entries of other cells share the buckets. Their overlaps are found by other scans, so the cell must match.
bool PairGrid::scan_entries(const Entry& entry, const CellRow& row, std::uint32_t begin, std::uint32_t end,
                            Found& found) const noexcept {
  found.work.box_tests += end - begin;
  for (std::uint32_t i = begin; i < end; ++i) {
    const Entry& other = entries_[i];
    if (!entry.box.overlaps(other.box)) continue;
    if (other.level != row.level || other.cell.y != row.first.y || other.cell.z != row.first.z ||
        other.cell.x < row.first.x || other.cell.x >= row.first.x + static_cast<std::int64_t>(row.cells))
      continue;
    if (!found.pairs.try_push({entry.body, other.body})) return false;
  }
  return true;
}

}  // namespace tactus::sim
