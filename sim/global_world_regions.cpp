// The global world by regions: awake and fully sub-stepped near a sub-world; sleeping islands; coarse islands, far from
// every sub-world, with fewer sub-steps.
#include "sim/global_world.h"

namespace tactus::sim {

using haptics::SubWorldReport;

bool GlobalWorld::is_asleep(BodyId id) const noexcept {
  const std::optional<BodyIndex> body = islands_.index_of(id);
  return body && islands_.is_asleep(*body);
}

// Wakes the bodies named in the report that have fallen asleep since it was written.
void GlobalWorld::wake_for(const SubWorldReport& report) noexcept {
  if (islands_.asleep() == 0) return;
  const auto wake = [this](BodyId id) noexcept {
    if (const std::optional<BodyIndex> body = islands_.index_of(id)) (void)islands_.wake(*body, world_);
  };
  for (const auto& member : report.members) wake(member.id);
  for (const auto& entry : report.border) wake(entry.outside);
  for (const auto& entry : report.outside) wake(entry.id);
}

// Wakes the bodies in the device's boundary cube, which may become members at the end of the next step.
void GlobalWorld::wake_near(const Device& device) noexcept {
  if (islands_.asleep() == 0) return;
  (void)islands_.wake_in(device.extraction.region(world_.body(slot_of(device)), device.reported_proxy), world_);
}

// Updates kept_awake_ and regions_: the members of each sub-world, and the region from which it may take more.
void GlobalWorld::mark_kept_awake() noexcept {
  kept_awake_.fill(0);
  if (const auto* kinematics = world_.effects().find<physics::ScriptedMotion>())  // may start to move at any time
    for (const auto& script : kinematics->scripts())
      if (const std::optional<BodyIndex> body = islands_.index_of(script.id)) kept_awake_[*body] = 1;
  for (std::size_t d = 0; d < devices_.size(); ++d) {
    const Device& device = devices_[d];
    kept_awake_[device.proxy] = 1;
    for (const BodyIndex member : device.extraction.members()) kept_awake_[member] = 1;
    regions_[d] = device.extraction.region(islands_.bodies()[device.proxy], device.reported_proxy);
  }
}

void GlobalWorld::sleep() noexcept {
  mark_kept_awake();
  islands_.put_to_sleep(kept_awake_, regions_, bounds_settings_, sub_step_s(), world_);
}

// Islands without a member, outside every proxy's region. They are independent of the other islands, so they may have
// their own number of sub-steps. Their contacts' stiffness does not change.
physics::CoarseRegion GlobalWorld::coarse_region() noexcept {
  if (bounds_settings_.sub_steps == settings_.sub_steps) return {};
  mark_kept_awake();
  return {islands_.find_coarse(kept_awake_, regions_, world_), bounds_settings_.sub_steps};
}

void GlobalWorld::sleep_from_start() noexcept {
  world_.begin_step(bounds_settings_);
  if (!pair_cache_.find(world_.bounds(), world_.dynamic_pairs())) statistics_.capacity_bits |= physics::kPairsFull;
  islands_.count_resting_as_slow();
  sleep();
}

}  // namespace tactus::sim
