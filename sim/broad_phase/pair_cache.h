// Finds overlapping boxes of moving bodies when most bodies hardly move: PairGrid's pairs, kept from step to step.
//
// Every body has a fat box: its box, grown on all sides by a fraction of its thickness. Pairs of overlapping fat boxes
// are kept, in order. A body that leaves its fat box gets a new one, and its pairs are searched again; every other pair
// costs one comparison. When many bodies move at once, as in a falling heap, nothing is kept and the grid finds the
// pairs of the step. The kept pairs are a cache, not state: the result equals the brute-force test's, independent of
// earlier steps and of the assignment of slots.
// Thread: construction [setup]; find: the owner, never allocates. Frame: any. Units: m. Bound: as PairGrid.
#pragma once

#include <span>
#include <vector>

#include "rt/physics/collision/pair_order.h"
#include "sim/broad_phase/box_grid.h"
#include "sim/broad_phase/pair_grid.h"

namespace tactus::sim {

class PairCache {
 public:
  // Number of steps, by the way in which their pairs were found.
  struct Work {
    std::uint64_t kept{0};     // the pairs of the step before, except those of bodies that left their fat box
    std::uint64_t rebuilt{0};  // new fat boxes for all bodies
    std::uint64_t direct{0};   // nothing kept
    std::uint64_t moved{0};    // bodies, not steps: that left their fat box, in steps counted in `kept`
  };

  PairCache(std::uint32_t max_bodies, std::uint32_t max_pairs);
  // [setup] From now on the grid's pairs are found in `parts` parts, by the executor.
  void share_work(const physics::Executor& executor, std::uint32_t parts);

  // Appends the pairs of overlapping boxes, each once. False: some did not fit.
  [[nodiscard]] bool find(std::span<const physics::Aabb> bounds, BoundedVector<physics::SlotPair>& pairs) noexcept;

  const Work& work() const noexcept { return work_; }

 private:
  void note_moved(std::span<const physics::Aabb> bounds) noexcept;
  bool rebuild(std::span<const physics::Aabb> bounds) noexcept;
  bool refresh(std::span<const physics::Aabb> bounds) noexcept;
  bool find_pairs_of_moved() noexcept;
  bool merge_found() noexcept;

  PairGrid grid_;
  BoxGrid fat_box_grid_;
  physics::PairOrder order_;
  std::vector<physics::Aabb> fat_boxes_;    // m, by slot
  std::vector<std::uint8_t> has_moved_;     // by slot: 1 if in `moved_`
  std::vector<std::uint32_t> moved_;        // slots of bodies that left their fat box, ascending
  BoundedVector<physics::SlotPair> kept_;   // by key: all pairs of overlapping fat boxes
  BoundedVector<physics::SlotPair> found_;  // pairs of the bodies in `moved_`
  std::uint32_t count_{0};                  // bodies that have a fat box
  bool holds_{false};                       // `kept_` and `fat_boxes_` are valid
  bool in_space_{false};                    // `fat_box_grid_` has all fat boxes
  std::uint32_t age_{0};                    // steps since the last rebuild
  std::uint32_t pause_{0};                  // remaining steps for which nothing is kept
  Work work_;
};

}  // namespace tactus::sim
