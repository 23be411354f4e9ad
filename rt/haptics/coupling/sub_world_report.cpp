// Fills the report of a synchronisation: members, border, and contacts of the leavers.
#include "rt/haptics/coupling/snapshot_bytes.h"
#include "rt/haptics/coupling/sub_world.h"

namespace tactus::haptics {

void SubWorld::fill_report(const WorldSnapshot& snapshot, const Leaving& leaving,
                           SubWorldReport& report) const noexcept {
  report.cycle = snapshot.cycle;
  report.ticks = state_.ticks_in_cycle;
  report.epoch = state_.epoch;
  report.wanted_epoch = state_.wanted_epoch;
  report.proxy_work_J = state_.proxy_work_J;
  report.border_tank_J = state_.tank.balance_J();
  report.proxy_start = state_.proxy_start;
  report.members.clear();
  report.border.clear();
  report.outside.clear();
  report.warm_starts.clear();
  report.effects.clear();
  report.mean_device_wrench = {};
  report.device = state_.device.latest();
  if (!coupling_.imposes_motion) {
    report.device = state_.device.over_cycle(state_.ticks_in_cycle, config_.step.dt);
    return;
  }
  report.mean_device_wrench = mean_device_wrench();
  for (const auto& body : world_.bodies()) {
    if (coupling_.members_frozen && body.id != config_.proxy) continue;
    // Always fits: a sub-world that exchanges has at most kMaxMembers members, because joins have the same capacity.
    if (!report.members.try_push({.id = body.id, .motion = body.motion})) break;
  }
  report_leavers(leaving, report);
  report_border(report);
  (void)write_effects(world_, {}, report.effects);
}

// Reports the impulses of the leavers' contacts, as the global world's warm start.
void SubWorld::report_leavers(const Leaving& leaving, SubWorldReport& report) const noexcept {
  if (!leaving.any) return;
  for (const auto& contact : world_.contacts()) {
    const bool one_leaves = leaving.slots[contact.slot_a] || (!contact.b_fixed && leaving.slots[contact.slot_b]);
    if (one_leaves && !report.warm_starts.try_push(physics::World::warm_start_of(contact, last_sub_step_s()))) return;
  }
}

void SubWorld::report_border(SubWorldReport& report) const noexcept {
  for (const auto& ghost : world_.border_ghosts())
    if (!report.outside.try_push({.id = ghost.outside, .impulse = ghost.total_impulse})) break;
  if (border_.returns == physics::BorderTraits::Return::kNothing) return;
  const physics::Body* member = nullptr;
  for (const auto& contact : world_.border_contacts()) {
    if (member == nullptr || member->id != contact.member) member = world_.find(contact.member);
    if (member == nullptr) continue;
    const Posed& pose = member->motion.pose;
    const BorderReturn entry{.member = contact.member,
                             .outside = contact.outside,
                             .feature = contact.feature,
                             .parts = contact.parts,
                             .point = contact.point_on(pose),
                             .normal = contact.normal,
                             .tangent_impulse = contact.total_tangent_impulse,
                             .normal_impulse_Ns = contact.total_normal_impulse};
    if (!report.border.try_push(entry)) break;
  }
}

}  // namespace tactus::haptics
