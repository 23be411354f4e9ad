#include "hal/falcon/falcon_logic.h"

#include "hal/falcon/falcon_faults.h"
#include "hal/kinematics/workspace_bounds.h"

namespace tactus::hal {
namespace {

using haptics::DeviceState;
using haptics::ReadStatus;

constexpr double kMotorEnd = 4095;
constexpr std::uint8_t kAllHomed = 7;

}  // namespace

FalconLogic::FalconLogic(double gain_per_Nm, std::int64_t period_ns)
    : gain_per_Nm_(gain_per_Nm), period_ns_(period_ns) {
  const AxisVector quantum{DeltaArm::kCount_rad, DeltaArm::kCount_rad, DeltaArm::kCount_rad, 0, 0, 0};
  const WorkspaceBounds bounds = bounds_over(DeltaArm(), quantum,
                                             {.workspace_radius_m = DeltaArm::kWorkspaceRadius_m,
                                              .force_N = kFalconForce_N,
                                              .torque_Nm = 0,
                                              .speed_m_per_s = 1,
                                              .angular_speed_rad_per_s = 0});
  properties_.has_rotation = false;
  properties_.workspace_radius_m = DeltaArm::kWorkspaceRadius_m;
  properties_.max_speed_m_per_s = 1.5;
  properties_.max_force_N = kFalconForce_N;
  properties_.continuous_force_N = 2.5;  // an estimate, as are mass, damping and friction
  properties_.max_torque_Nm = properties_.continuous_torque_Nm = 0;
  properties_.position_quantum_m = bounds.position_quantum_m;
  properties_.mass_kg = 0.2;
  properties_.damping_Ns_per_m = 1;
  properties_.coulomb_friction_N = 0.3;
  properties_.delay_s = 2e-9 * static_cast<double>(period_ns);  // the port's thread adds a period
}

void FalconLogic::read(const FalconState* fresh, bool connected, std::uint64_t echoed,
                       haptics::DeviceInput& input) noexcept {
  ++periods_;
  states_.begin_period();
  const bool pushes = states_.state() == DeviceState::kForce;
  if (states_.commands_lost() && pushes) states_.brake(number_of(firmware::Fault::kCommandsLost));
  input.status = connected ? ReadStatus::kMissing : ReadStatus::kDisconnected;
  if (fresh != nullptr && connected) {
    homed_ = fresh->homed == kAllHomed;
    if (!homed_ && pushes) states_.brake(kFalconNotHomed);
    AxisVector q{};
    for (unsigned i = 0; i < 3; ++i)
      q[i] = DeltaArm::kZeroCount_rad + fresh->counts[i] * DeltaArm::kCount_rad - DeltaArm::centre_angle();
    Vec3d place = place_;
    const bool found = DeltaArm::solve(q, place) || (place = {0, 0, 0.125}, DeltaArm::solve(q, place));
    input.status = found ? ReadStatus::kFresh : ReadStatus::kCorrupt;
    if (found) {
      place_ = place;
      q_ = q;
      sample_.device_from_tool.position = DeltaArm::device_from_maker(place);
      ++sample_.sequence;
      sample_.device_time_ns = periods_ * static_cast<std::uint64_t>(period_ns_);
      sample_.buttons = fresh->buttons;
      sample_.echoed_sequence = echoed;
    }
  }
  sample_.state = states_.state();
  sample_.device_fault = states_.fault();
  sample_.limits = homed_ ? 0u : firmware::bit_of(firmware::Limit::kNotHomed);
  input.sample = sample_;
}

void FalconLogic::write(const haptics::DeviceCommand& command) noexcept {
  if (states_.accept(command, homed_) == HostStates::Next::kStay) return;
  states_.enter(command.wanted == DeviceState::kForce && homed_ ? DeviceState::kForce : DeviceState::kIdle);
}

FalconRequest FalconLogic::request() const noexcept {
  const bool pushes = states_.state() == DeviceState::kForce;
  FalconRequest request{.green = pushes, .blue = homed_, .red = !homed_};
  if (!pushes) return request;
  const Vec3d& force = states_.command().wrench.force;
  const double size = norm(force);
  const double share = share_after(states_.missed()) * (size > kFalconForce_N ? kFalconForce_N / size : 1.0);
  const AxisVector effort = DeltaArm().efforts_of(q_, {force * share, {}});
  // Cut after scaling and with the direction kept: before it, the 16 bits would wrap.
  double largest = 0;
  for (unsigned i = 0; i < 3; ++i) largest = std::max(largest, std::abs(gain_per_Nm_ * effort[i]));
  const double cut = largest > kMotorEnd ? kMotorEnd / largest : 1.0;
  for (unsigned i = 0; i < 3; ++i)
    request.motors[i] = static_cast<std::int16_t>(std::lround(-gain_per_Nm_ * effort[i] * cut));
  return request;
}

}  // namespace tactus::hal
