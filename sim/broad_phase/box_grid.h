// A persistent grid of boxes for overlap queries: sleeping bodies, and the fat boxes of PairCache. Boxes are inserted
// and removed one by one.
//
// A hierarchical uniform grid, as PairGrid, but kept from step to step: a box is stored in the cell of its lower
// corner, on the level whose cells are just larger than it, in a list per hashed cell. Insert and remove are O(1); a
// query costs a few cells for each level in use, independent of the number of boxes. A query finds exactly the boxes of
// the brute-force test; their order follows from the order of insertion.
// Thread: construction [setup]; the rest: the owner, never allocates. Frame: any. Units: m. Bound: as many boxes as
// given at construction; a box's number is below that.
#pragma once

#include <array>
#include <vector>

#include "rt/physics/shapes/shape.h"

namespace tactus::sim {

class BoxGrid {
 public:
  explicit BoxGrid(std::uint32_t max_bodies);

  void insert(std::uint32_t body, const physics::Aabb& box) noexcept;
  void remove(std::uint32_t body) noexcept;
  void clear() noexcept;  // linear in boxes + cells
  std::uint32_t size() const noexcept { return size_; }

  // Calls found(body) for each box that overlaps; `found` must not insert or remove.
  template <class F>
  void find(const physics::Aabb& box, F&& found) const noexcept {
    for (std::uint32_t level = 0; level < kLevels; ++level) {
      if (population_[level] == 0) continue;
      const Cells cells = cells_under(box, level);
      if (cells.count() > population_[level])
        scan_all(level, box, found);
      else
        scan(cells, level, box, found);
    }
  }

 private:
  static constexpr std::uint32_t kLevels = 40;         // each twice as coarse as the one before
  static constexpr std::uint32_t kOneMetre = 20;       // the level of cells of 1 m
  static constexpr std::uint32_t kTop = kLevels - 1;   // one cell, for all larger boxes
  static constexpr std::uint32_t kNone = 0xffffffffu;  // end of a list

  struct Cell {
    std::int64_t x, y, z;
    bool operator==(const Cell&) const = default;
  };
  struct Cells {  // a block of cells, both ends included
    Cell low, high;
    std::uint64_t count() const noexcept;
  };
  struct Entry {
    physics::Aabb box;
    Cell cell{};
    std::uint32_t level{0}, bucket{0};
    std::uint32_t next{kNone}, before{kNone};  // in the bucket's list
    bool inside{false};
  };

  static std::uint32_t level_of(const physics::Aabb& box) noexcept;
  static std::int64_t coordinate(double x_m, std::uint32_t level) noexcept;
  static Cell cell_of(const Vec3d& corner, std::uint32_t level) noexcept;
  static Cells cells_under(const physics::Aabb& box, std::uint32_t level) noexcept;
  std::uint32_t bucket_of(const Cell& cell, std::uint32_t level) const noexcept;

  template <class F>
  void scan(const Cells& cells, std::uint32_t level, const physics::Aabb& box, F&& found) const noexcept {
    for (std::int64_t z = cells.low.z; z <= cells.high.z; ++z)
      for (std::int64_t y = cells.low.y; y <= cells.high.y; ++y)
        for (std::int64_t x = cells.low.x; x <= cells.high.x; ++x) {
          const Cell cell{x, y, z};
          for (std::uint32_t body = head_[bucket_of(cell, level)]; body != kNone; body = entries_[body].next) {
            const Entry& entry = entries_[body];
            // Several cells share a bucket.
            if (entry.level == level && entry.cell == cell && entry.box.overlaps(box)) found(body);
          }
        }
  }
  // For a box that covers more cells than the level has bodies.
  template <class F>
  void scan_all(std::uint32_t level, const physics::Aabb& box, F&& found) const noexcept {
    for (std::uint32_t body = 0; body < entries_.size(); ++body) {
      const Entry& entry = entries_[body];
      if (entry.inside && entry.level == level && entry.box.overlaps(box)) found(body);
    }
  }

  std::vector<Entry> entries_;       // by body
  std::vector<std::uint32_t> head_;  // by bucket
  std::uint32_t mask_;               // buckets - 1, a power of two
  std::array<std::uint32_t, kLevels> population_{};
  std::uint32_t size_{0};
};

}  // namespace tactus::sim
