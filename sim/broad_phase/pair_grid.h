// Broad phase: finds overlapping boxes of moving bodies, with work that grows with bodies + pairs, not with bodies
// squared.
//
// A hierarchical uniform grid. Every box is stored in the cell of its lower corner, on the level whose cells are just
// larger than it. So a box can overlap others of its level only in adjacent cells, and larger ones only in the few
// cells that it covers. Levels are chosen from the boxes' sizes in each call; cells are hashed into a table that a
// counting sort fills. Finds exactly the pairs of the brute-force test, for any positions and sizes. The order is fixed
// by the input, also when an executor finds parts in parallel. Static geometry is not included (the world keeps it
// apart).
// Thread: construction [setup]; find: the owner, never allocates. Frame: any. Units: m. Bound: as many boxes as given
// at construction (an assert beyond); pairs beyond the vector's capacity are left out and find returns false. Boxes
// with a NaN coordinate overlap nothing.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "rt/physics/world.h"

namespace tactus::sim {

class PairGrid {
 public:
  // Work of the last find: counts that are the same on every machine.
  struct Work {
    std::uint64_t box_tests{0};  // pairs of boxes compared
    std::uint64_t rows{0};       // rows of cells looked up
  };

  explicit PairGrid(std::uint32_t max_bodies);
  // [setup] From now on pairs are found in `parts` parts, by the executor; each part holds up to `max_pairs`.
  void share_work(const physics::Executor& executor, std::uint32_t parts, std::uint32_t max_pairs);

  // Appends the pairs of overlapping boxes, each once, a and b in no particular order. False: some did not fit.
  [[nodiscard]] bool find(std::span<const physics::Aabb> bounds, BoundedVector<physics::SlotPair>& pairs) noexcept;

  const Work& work() const noexcept { return work_; }

 private:
  static constexpr int kLevels = 64;             // each twice as coarse as the one before
  static constexpr int kBaseLevel = 24;          // the level of the most frequent size
  static constexpr int kTopLevel = kLevels - 1;  // one cell, for all larger boxes

  struct Cell {
    std::int64_t x, y, z;
  };
  struct Entry {  // a box; entries are sorted by bucket
    physics::Aabb box;
    Cell cell;
    std::uint32_t body, level;
  };
  struct CellRow {  // neighbouring cells of a level, along x
    std::uint32_t level;
    Cell first;
    std::uint32_t cells;
  };
  struct Found {
    BoundedVector<physics::SlotPair>& pairs;
    Work work;
  };
  struct alignas(64) Part {  // the pairs found from a range of the entries
    BoundedVector<physics::SlotPair> pairs;
    Work work;
    bool all{true};  // no pair was left out
  };

  void choose_levels(std::span<const physics::Aabb> bounds) noexcept;
  void fill_table(std::span<const physics::Aabb> bounds) noexcept;
  bool find_from(std::uint32_t begin, std::uint32_t end, Found& found) const noexcept;
  bool find_in_parts(BoundedVector<physics::SlotPair>& pairs) noexcept;
  int level_of(const physics::Aabb& box) const noexcept;
  std::int64_t coordinate(double x_m, std::uint32_t level) const noexcept;
  Cell cell_of(const Vec3d& corner, std::uint32_t level) const noexcept;
  std::uint32_t bucket_of(const Cell& cell, std::uint32_t level) const noexcept;

  bool find_on_own_level(std::uint32_t index, Found& found) const noexcept;
  bool find_on_coarser_level(std::uint32_t index, std::uint32_t level, Found& found) const noexcept;
  bool scan_row(const Entry& entry, const CellRow& row, Found& found) const noexcept;
  bool scan_entries(const Entry& entry, const CellRow& row, std::uint32_t begin, std::uint32_t end,
                    Found& found) const noexcept;

  std::vector<Entry> entries_;
  std::vector<std::uint32_t> bucket_;  // by body
  std::vector<std::uint32_t> level_;   // by body
  std::vector<std::uint32_t> start_;   // by bucket; one more than buckets
  std::uint32_t mask_{0};              // buckets - 1, a power of two
  double base_cell_m_{1};
  std::array<double, kLevels> cells_per_m_{};
  std::array<std::uint32_t, kLevels> population_{};
  std::uint32_t coarsest_{0};  // coarsest level in use
  std::uint32_t count_{0};
  Work work_;
  physics::Executor executor_;
  std::vector<Part> parts_;  // empty: the work is not shared
};

}  // namespace tactus::sim
