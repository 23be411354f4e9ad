// The global world's prediction of a haptic sub-world: the same members against the same ghosts over the same cycle,
// with the hand extrapolated as in the global step. What it misses of that step is the error of the border, which a
// snapshot corrects (rt/haptics/coupling/border_correction.h).
//
// In each cycle, in this order: `run` with the report that begins the cycle, the global step, `find_corrected` and
// `fill_corrections` with the next snapshot, `adopt` that snapshot. Thread: the global world's; construction [setup];
// the rest allocates nothing. Frame: world. Units: SI. Work: `ratio` ticks of the sub-world.
#pragma once

#include <algorithm>
#include <array>

#include "rt/haptics/coupling/sub_world.h"
#include "rt/physics/islands.h"
#include "rt/physics/world.h"
#include "sim/exchange/extrapolated_hand.h"

namespace tactus::sim {

class SubWorldPrediction {
 public:
  SubWorldPrediction(const haptics::SubWorldConfig& config, std::span<const physics::Body> fixed_bodies)
      : sub_world_(config, fixed_bodies) {}

  // Begins the cycle of this snapshot as the haptic side will.
  void adopt(const haptics::WorldSnapshot& snapshot) noexcept;

  // Runs the cycle from the state that the report contains.
  void run(const haptics::SubWorldReport& report, const ExtrapolatedHand& hand) noexcept;

  // Finds the members to correct: those of islands in which a member met an outside body in the cycle, in the sub-world
  // or, by the border of `next`, in the global step. Of the other islands the sub-world knew all that moves them, with
  // its own sub-steps, and keeps their state. Call after the global step over the same cycle, with that border filled.
  void find_corrected(const haptics::WorldSnapshot& next) noexcept;
  bool corrects(BodyId member) const noexcept {
    return std::binary_search(corrected_.begin(), corrected_.end(), member);
  }
  // Of the members that `find_corrected` found.
  void fill_corrections(const physics::World& global, haptics::WorldSnapshot& next) const noexcept;

  // What the sub-world's members gave to outside bodies in the cycle that the report ends, beyond the prediction: what
  // they have not yet got in the global world. Call before `run`. Empty where the two do not cover the same ticks, and
  // with an empty tank (border_correction.h).
  std::span<const haptics::OutsideImpulse> not_predicted(const haptics::SubWorldReport& report) noexcept;

  const haptics::SubWorld& sub_world() const noexcept { return sub_world_; }
  const physics::StepReport& last_tick() const noexcept { return last_tick_; }

  void save(ByteWriter& out) const noexcept;
  [[nodiscard]] bool restore(ByteReader& in) noexcept;
  std::size_t save_size_bound() const noexcept;

 private:
  using Impulses = FixedVector<haptics::OutsideImpulse, haptics::kMaxOutsideBodies>;

  haptics::SubWorld sub_world_;
  haptics::SubWorldReport report_{};  // scratch of adopt; its ghosts' impulses are those of the last cycle
  Impulses beyond_{};                 // scratch of not_predicted
  physics::StepReport last_tick_{};
  // Scratch of find_corrected, by slot; and what it found, ascending.
  std::array<std::uint32_t, haptics::kMaxMembers> parents_{};
  std::array<bool, haptics::kMaxMembers> marked_{};
  FixedVector<BodyId, haptics::kMaxMembers> corrected_{};
};

}  // namespace tactus::sim
