#include "rt/loop/run_stats.h"

namespace tactus::loop {

OverrunCause classify_overrun(double wake_late_ns, double used_ns, double predicted_ns, double period_ns) noexcept {
  if (used_ns > period_ns && 2 * predicted_ns >= used_ns) return OverrunCause::kOwnWork;
  const double needed_ns = std::min(used_ns, 2 * predicted_ns);
  if (wake_late_ns > 0.5 * period_ns || wake_late_ns + needed_ns > period_ns) return OverrunCause::kLateWake;
  return OverrunCause::kInterrupted;
}

void CostPredictionStats::add(double predicted, double measured) noexcept {
  predicted_ns.record(static_cast<std::int64_t>(predicted));
  measured_permille.record(static_cast<std::int64_t>(1000.0 * measured / std::max(predicted, 1.0)));
  if (measured > predicted) ++above;
}

void RunStats::add(const TickOutput& out, std::uint32_t sub_steps, std::uint32_t component, std::uint32_t cycle_ticks,
                   std::uint32_t ratio, const haptics::DeviceSample& device) noexcept {
  ++ticks;
  sub_steps_sum += sub_steps;
  if ((out.status & kProxyContact) != 0) ++contact_ticks;
  if ((out.status & kNotArmed) == 0) ++armed_ticks;
  for (std::uint32_t bit = 0; bit < 32; ++bit) status_ticks[bit] += (out.status >> bit) & 1u;
  members_max = std::max(members_max, out.members);
  border_max = std::max(border_max, out.border);
  contacts_max = std::max(contacts_max, out.contacts);
  points_max = std::max(points_max, out.points);
  pairs_max = std::max(pairs_max, out.pairs);
  component_max = std::max(component_max, component);
  capacity_bits |= out.capacity_bits;
  dropped += out.dropped;
  if (cycle_ticks > 0) {
    ++cycles;
    if (cycle_ticks > ratio) ++late_cycles;
    cycle_ticks_max = std::max<std::uint64_t>(cycle_ticks_max, cycle_ticks);
  }
  const Vec3d& force = out.command.wrench.force;
  force_max_N = std::max(force_max_N, norm(force));
  torque_max_Nm = std::max(torque_max_Nm, norm(out.command.wrench.torque));
  force_sum_N += norm(force);
  if (ticks > 1) force_step_max_N = std::max(force_step_max_N, norm(force - last_force_));
  last_force_ = force;
  deepest_m = std::max(deepest_m, out.deepest_m);
  deepest_share = std::max(deepest_share, out.deepest_share);
  device_energy_J = out.device_energy_J;
  damped_energy_J = out.damped_energy_J;
  border_work_J = out.border_work_J;
  corrected_J = out.corrected_J;
  border_tank_J = out.border_tank_J;
  if (out.fault == fault_now) return;
  const bool latched = out.fault != Fault::kNone;
  if (latched) ++fault_count;
  const FaultEvent event{.tick = out.tick,
                         .fault = latched ? out.fault : fault_now,
                         .cleared = latched ? 0u : 1u,
                         .device_state = device.state,
                         .device_fault = device.device_fault,
                         .device_limits = device.limits};
  if (!faults.try_push(event)) {
    faults[faults.size() - 1] = event;
    ++fault_events_dropped;
  }
  fault_now = out.fault;
}

}  // namespace tactus::loop
