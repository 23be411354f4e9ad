// Which boxes of moving bodies overlap, where most of them hardly move: PairGrid's pairs, kept from step to step.
//
// Every body has room: its box, grown on all sides by a share of its thickness. Pairs whose rooms overlap are kept, in
// order. A body that leaves its room gets a new one, and its pairs are looked for again; the others cost a comparison.
// Where much moves at once, a heap that falls, nothing is worth keeping, and the grid finds the pairs of the step.
// What is kept is a bound, not state: the pairs are those of the brute-force test, whatever came before, and whoever
// has a slot. Thread: construction [setup]; find: the owner, never allocates. Frame: any. Units: m.
// Bound: as PairGrid.
#pragma once

#include <span>
#include <vector>

#include "rt/physics/collision/pair_order.h"
#include "sim/broad_phase/box_grid.h"
#include "sim/broad_phase/pair_grid.h"

namespace tactus::sim {

class PairCache {
 public:
  // Steps so far, by how their pairs were found.
  struct Work {
    std::uint64_t kept{0};     // with the pairs of the step before, but for those of bodies that moved
    std::uint64_t rebuilt{0};  // rooms for all
    std::uint64_t direct{0};   // nothing kept
    std::uint64_t moved{0};    // bodies that left their room, in steps of the first kind
  };

  PairCache(std::uint32_t max_bodies, std::uint32_t max_pairs);
  // [setup] From now on the grid's pairs are found in that many parts.
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
  BoxGrid rooms_in_space_;
  physics::PairOrder order_;
  std::vector<physics::Aabb> room_;         // by slot
  std::vector<std::uint8_t> has_moved_;     // by slot: among `moved_`
  std::vector<std::uint32_t> moved_;        // slots, ascending
  BoundedVector<physics::SlotPair> kept_;   // by key: all whose rooms overlap
  BoundedVector<physics::SlotPair> found_;  // of those that moved
  std::uint32_t count_{0};                  // of bodies that have room
  bool holds_{false};                       // `kept_` and `room_` do
  bool in_space_{false};                    // `rooms_in_space_` has them all
  std::uint32_t age_{0};                    // steps since all rooms were new
  std::uint32_t pause_{0};                  // steps for which nothing is kept
  Work work_;
};

}  // namespace tactus::sim
