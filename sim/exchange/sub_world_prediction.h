// The global world's prediction of a haptic sub-world: the same members against the same ghosts over the same cycle,
// with the hand extrapolated as in the global step. What it misses of that step is the error of the border, which a
// snapshot corrects (rt/haptics/coupling/border_correction.h).
//
// In each cycle, in this order: `run` with the report that begins the cycle, the global step, `fill_corrections` into
// the next snapshot, `adopt` that snapshot. Thread: the global world's; construction [setup]; the rest allocates
// nothing. Frame: world. Units: SI. Work: `ratio` ticks of the sub-world.
#pragma once

#include "rt/haptics/coupling/sub_world.h"
#include "rt/physics/world.h"

namespace tactus::sim {

class SubWorldPrediction {
 public:
  SubWorldPrediction(const haptics::SubWorldConfig& config, std::span<const physics::Body> fixed_bodies)
      : sub_world_(config, fixed_bodies) {}

  // Begins the cycle of this snapshot as the haptic side will.
  void adopt(const haptics::WorldSnapshot& snapshot) noexcept;

  // Runs the cycle from the state that the report contains, with the device moving on at the velocity of `device`.
  void run(const haptics::SubWorldReport& report, haptics::DeviceTarget device) noexcept;

  // Did members meet outside bodies in the cycle, in the sub-world or, by the border of `next`, in the global step? If
  // not, the sub-world knew all that moves its members, with its own sub-steps, and keeps their state.
  bool has_border(const haptics::WorldSnapshot& next) const noexcept {
    return !next.border.empty() || !next.outside.empty() || sub_world_.border_contacts() > 0 ||
           !sub_world_.world().border_ghosts().empty();
  }
  // Call after the global step over the same cycle, with the border of `next` filled. Fills none without a border.
  void fill_corrections(const physics::World& global, haptics::WorldSnapshot& next) const noexcept;

  // What the sub-world's members gave to outside bodies in the cycle that the report ends, beyond the prediction: what
  // they have not yet got in the global world. Call before `run`. Empty where the two do not cover the same ticks.
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
};

}  // namespace tactus::sim
