#include "tools/library/tick_record.h"

#include <bit>

#include "hal/host_faults.h"
#include "tools/library/values.h"

namespace tactus {
namespace {

constexpr bool same(FaultCode ours, Fault inner) noexcept {
  return static_cast<std::uint32_t>(ours) == static_cast<std::uint32_t>(inner);
}
constexpr bool same(Condition ours, StatusBit inner) noexcept {
  return static_cast<std::uint32_t>(ours) == static_cast<std::uint32_t>(inner);
}
static_assert(
    same(FaultCode::kLinkLost, Fault::kLinkLost) && same(FaultCode::kDeviceUnplugged, Fault::kDeviceUnplugged) &&
    same(FaultCode::kInputNotFinite, Fault::kInputNotFinite) &&
    same(FaultCode::kInputRotation, Fault::kInputRotation) &&
    same(FaultCode::kInputWorkspace, Fault::kInputWorkspace) && same(FaultCode::kInputJump, Fault::kInputJump) &&
    same(FaultCode::kInputStale, Fault::kInputStale) && same(FaultCode::kDeviceBrake, Fault::kDeviceBrake) &&
    same(FaultCode::kDeviceFault, Fault::kDeviceFault) && same(FaultCode::kOutputNotFinite, Fault::kOutputNotFinite) &&
    same(FaultCode::kEmergencyStop, Fault::kEmergencyStop) && same(FaultCode::kWorldLost, Fault::kWorldLost) &&
    same(FaultCode::kDeviceLeftForce, Fault::kDeviceLeftForce) && same(FaultCode::kForceRefused, Fault::kForceRefused));
static_assert(same(Condition::kFrameMissing, kFrameMissing) && same(Condition::kForceFading, kForceFading) &&
              same(Condition::kInputRejected, kInputRejected) && same(Condition::kForceSaturated, kForceSaturated) &&
              same(Condition::kSlewLimited, kSlewLimited) && same(Condition::kPassivityActive, kPassivityActive) &&
              same(Condition::kWorldLate, kWorldLate) && same(Condition::kBorderFrozen, kBorderFrozen) &&
              same(Condition::kWorldFade, kWorldFade) && same(Condition::kSolverCut, kSolverCut) &&
              same(Condition::kSubStepsReduced, kSubStepsReduced) &&
              same(Condition::kCapacityExceeded, kCapacityExceeded) && same(Condition::kNotArmed, kNotArmed) &&
              same(Condition::kProxyContact, kProxyContact) && same(Condition::kBorderSpent, kBorderSpent) &&
              same(Condition::kSceneReset, kSceneReset));

}  // namespace

std::string_view describe(FaultCode fault) noexcept { return describe(static_cast<Fault>(fault)); }
std::string_view describe(Condition condition) noexcept {
  const auto bit = static_cast<std::uint32_t>(condition);
  return std::has_single_bit(bit) ? name_of(static_cast<StatusBit>(bit)) : std::string_view();
}

Tick library::to_tick(const session::Driver& driver, double period_s) noexcept {
  const loop::TickOutput& out = driver.output();
  const haptics::DeviceSample& sample = driver.sample();
  Tick tick;
  tick.number = out.tick;
  tick.time_s = static_cast<double>(out.tick + 1) * period_s;
  tick.force_N = to_public(out.command.wrench.force);
  tick.torque_Nm = to_public(out.command.wrench.torque);
  tick.proxy_position_m = to_public(out.proxy.pose.position);
  tick.proxy_rotation = to_public(out.proxy.pose.rotation);
  tick.proxy_velocity_m_per_s = to_public(out.proxy.velocity.linear);
  tick.proxy_angular_velocity_rad_per_s = to_public(out.proxy.velocity.angular);
  tick.target_position_m = to_public(out.target.position);
  tick.target_rotation = to_public(out.target.rotation);
  tick.tool_position_m = to_public(sample.device_from_tool.position);
  tick.tool_rotation = to_public(sample.device_from_tool.rotation);
  tick.device_energy_J = out.device_energy_J;
  tick.damped_energy_J = out.damped_energy_J;
  tick.border_work_J = out.border_work_J;
  tick.border_tank_J = out.border_tank_J;
  tick.deepest_overlap_m = out.deepest_m;
  tick.fault = static_cast<FaultCode>(out.fault);
  tick.conditions = out.status;
  tick.device_fault = hal::shown_fault(sample.device_fault);
  tick.buttons = sample.buttons;
  tick.members = out.members;
  tick.border = out.border;
  tick.contacts = out.contacts;
  tick.sub_steps = driver.sub_steps();
  tick.synchronised = driver.synchronised() ? 1 : 0;
  return tick;
}

}  // namespace tactus
