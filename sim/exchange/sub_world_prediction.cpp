#include "sim/exchange/sub_world_prediction.h"

#include <algorithm>

#include "rt/base/list_bytes.h"
#include "rt/haptics/coupling/border_correction.h"
#include "rt/haptics/coupling/device_track.h"

namespace tactus::sim {

using haptics::OutsideImpulse;
using haptics::SubWorldReport;
using haptics::WorldSnapshot;

void SubWorldPrediction::adopt(const WorldSnapshot& snapshot) noexcept { sub_world_.synchronise(snapshot, report_); }

void SubWorldPrediction::run(const SubWorldReport& report, haptics::DeviceTarget device) noexcept {
  const auto& config = sub_world_.config();
  sub_world_.continue_from(report);
  for (std::uint32_t tick = 0; tick < config.ratio; ++tick) {
    last_tick_ = sub_world_.step(device, config.step.sub_steps, {}).report;
    device = haptics::moved_on(device, config.step.dt);
  }
}

void SubWorldPrediction::fill_corrections(const physics::World& global, WorldSnapshot& next) const noexcept {
  const bool has_run = sub_world_.ticks_in_cycle() > 0;  // since the last snapshot
  if (!has_run || !has_border(next)) return;
  for (const physics::Body& member : sub_world_.world().bodies())
    if (const physics::Body* const body = global.find(member.id))
      (void)next.corrections.try_push(haptics::correction_between(member.id, member.motion, body->motion));  // fits
}

std::span<const OutsideImpulse> SubWorldPrediction::not_predicted(const SubWorldReport& report) noexcept {
  beyond_.clear();
  if (report.ticks != report_.ticks) return {};
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
