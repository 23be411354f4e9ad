#include "sim/exchange/sub_world_prediction.h"

#include <algorithm>

#include "rt/base/list_bytes.h"
#include "rt/haptics/coupling/border_correction.h"

namespace tactus::sim {

using haptics::OutsideImpulse;
using haptics::SubWorldReport;
using haptics::WorldSnapshot;

void SubWorldPrediction::adopt(const WorldSnapshot& snapshot) noexcept { sub_world_.synchronise(snapshot, report_); }

void SubWorldPrediction::run(const SubWorldReport& report, const ExtrapolatedHand& hand) noexcept {
  const auto& config = sub_world_.config();
  sub_world_.continue_from(report);
  for (std::uint32_t tick = 0; tick < config.ratio; ++tick)
    last_tick_ = sub_world_.step(hand.after(tick * config.step.dt), config.step.sub_steps, {}).report;
}

void SubWorldPrediction::find_corrected(const WorldSnapshot& next) noexcept {
  corrected_.clear();
  const bool has_run = sub_world_.ticks_in_cycle() > 0;  // since the last snapshot
  if (!has_run) return;
  const physics::World& world = sub_world_.world();
  const auto bodies = world.bodies();
  physics::Islands islands({parents_.data(), bodies.size()});
  for (const auto& contact : world.contacts())
    if (!contact.b_fixed) islands.link(contact.slot_a, contact.slot_b);
  const auto* const joints = world.effects().find<physics::Joints>();
  if (joints != nullptr)
    joints->for_each_link(bodies,
                          [&islands](std::uint32_t a, std::uint32_t b, std::uint32_t) noexcept { islands.link(a, b); });

  std::fill_n(marked_.begin(), bodies.size(), false);
  const auto mark_island = [&](BodyId member) {
    if (const auto slot = world.slot_of(member)) marked_[islands.of(number_of(*slot))] = true;
  };
  for (const auto& contact : world.border_contacts()) mark_island(contact.member);
  for (const auto& point : next.border) mark_island(point.member);
  if (joints != nullptr)
    for (const physics::Joint& joint : joints->joints()) {
      if (joint.a == kNoBody) continue;
      if (!world.slot_of(joint.a)) mark_island(joint.b);
      if (!world.slot_of(joint.b)) mark_island(joint.a);
    }
  for (std::uint32_t slot = 0; slot < bodies.size(); ++slot)
    if (marked_[islands.of(slot)]) (void)corrected_.try_push(bodies[slot].id);  // fits
}

void SubWorldPrediction::fill_corrections(const physics::World& global, WorldSnapshot& next) const noexcept {
  for (const BodyId id : corrected_) {
    const physics::Body *const member = sub_world_.world().find(id), *const body = global.find(id);
    if (member != nullptr && body != nullptr)
      (void)next.corrections.try_push(haptics::correction_between(id, member->motion, body->motion));  // fits
  }
}

std::span<const OutsideImpulse> SubWorldPrediction::not_predicted(const SubWorldReport& report) noexcept {
  beyond_.clear();
  const double initial_J = physics::traits_of(sub_world_.config().border_mode).tank_at_start_J;
  const double available_J = report.border_tank_J + sub_world_.border_credit_J();
  if (report.ticks != report_.ticks || physics::is_empty(available_J, initial_J)) return {};
  for (const OutsideImpulse& given : report.outside) {
    const auto predicted = std::lower_bound(report_.outside.begin(), report_.outside.end(), given.id,
                                            [](const OutsideImpulse& p, BodyId id) { return p.id < id; });
    if (predicted != report_.outside.end() && predicted->id == given.id && is_finite(given.impulse))
      (void)beyond_.try_push({.id = given.id, .impulse = given.impulse - predicted->impulse});  // fits
  }
  return beyond_.span();
}

void SubWorldPrediction::save(ByteWriter& out) const noexcept {
  sub_world_.save(out);
  out.put(report_.ticks);
  write_list(out, report_.outside);
  out.put(last_tick_);
}

bool SubWorldPrediction::restore(ByteReader& in) noexcept {
  if (!sub_world_.restore(in)) return false;
  in.get(report_.ticks);
  if (!read_list(in, report_.outside)) return false;
  in.get(last_tick_);
  return in.ok();
}

std::size_t SubWorldPrediction::save_size_bound() const noexcept {
  return sub_world_.save_size_bound() + sizeof(report_.ticks) + sizeof(report_.outside) + sizeof(last_tick_);
}

}  // namespace tactus::sim
