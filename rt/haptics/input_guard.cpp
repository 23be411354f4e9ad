#include "rt/haptics/input_guard.h"

#include <algorithm>

namespace tactus::haptics {
namespace {

enum class Outcome {
  kBelieved,
  kMissing,   // no new sample: `fault` after kFadeOutTicks
  kRejected,  // an invalid new sample: `fault` after kRejectedTicks
  kFatal,     // `fault` at once
  kNotReady,  // the device has not yet cleared BRAKE or its fault after a rearm
};

struct Finding {
  Outcome outcome{Outcome::kMissing};
  Fault fault{Fault::kNone};
  Posed pose;
};

constexpr double kPi = 3.14159265358979323846;

// Fault from the device's own report. Valid also in a frame whose sequence is old: stopping is safe.
Fault device_fault_of(const InputGuard& guard, const DeviceSample& sample) noexcept {
  if (sample.device_fault != 0) {
    return sample.device_fault == guard.config.emergency_stop_fault ? Fault::kEmergencyStop : Fault::kDeviceFault;
  }
  return sample.state == DeviceState::kBrake && guard.state.was_in_force != 0 ? Fault::kDeviceBrake : Fault::kNone;
}

// Normalises the quaternion and selects the sign nearest to the last one, so that no filter sees a sign flip.
bool read_rotation(const InputGuard& guard, const Quatd& raw, Quatd& rotation) noexcept {
  if (!guard.config.device.has_rotation) {
    rotation = Quatd{};  // 3 DoF: the rotation in the frame is ignored
    return true;
  }
  if (!(std::abs(norm(raw) - 1.0) <= 1e-3)) return false;
  rotation = normalized(raw);
  const Quatd& last = guard.state.last.rotation;
  const bool flip =
      rotation.w * last.w + rotation.x * last.x + rotation.y * last.y + rotation.z * last.z < 0 && guard.state.based;
  if (flip) rotation = {-rotation.w, -rotation.x, -rotation.y, -rotation.z};
  return true;
}

// True if the pose moved more since the last accepted sample than 1.5 times the maximum speed allows, plus three
// quanta.
bool jumped(const InputGuard& guard, const Posed& pose) noexcept {
  const DeviceProperties& device = guard.config.device;
  const double time_s = guard.config.period_s * (1.0 + guard.state.missed);
  const double reach_m = 1.5 * device.max_speed_m_per_s * time_s + 3.0 * device.position_quantum_m;
  if (norm(pose.position - guard.state.last.position) > reach_m) return true;
  const double reach_rad =
      std::min(kPi, 1.5 * device.max_angular_speed_rad_per_s * time_s + 3.0 * device.rotation_quantum_rad);
  // The vector part of the difference is sin(angle / 2): compared by sine, so that no arc function is needed.
  const Quatd turned = pose.rotation * conjugate(guard.state.last.rotation);
  return norm(turned.vec()) > sin_cos(0.5 * reach_rad).sin;
}

// Checks the pose of a new sample against the device's properties.
Finding examine_pose(const InputGuard& guard, const Posed& raw) noexcept {
  const bool finite = is_finite(raw.position) && (!guard.config.device.has_rotation || is_finite(raw.rotation));
  if (!finite) return {Outcome::kRejected, Fault::kInputNotFinite, {}};
  Posed pose{raw.position, {}};
  if (!read_rotation(guard, raw.rotation, pose.rotation)) return {Outcome::kRejected, Fault::kInputRotation, {}};
  if (!(norm(pose.position) <= 1.05 * guard.config.device.workspace_radius_m)) {
    return {Outcome::kRejected, Fault::kInputWorkspace, {}};
  }
  if (guard.state.based != 0 && jumped(guard, pose)) return {Outcome::kRejected, Fault::kInputJump, {}};
  return {Outcome::kBelieved, Fault::kNone, pose};
}

Finding examine(InputGuard& guard, const DeviceInput& input) noexcept {
  InputGuard::State& state = guard.state;
  if (input.status == ReadStatus::kDisconnected) return {Outcome::kFatal, Fault::kDeviceUnplugged, {}};
  if (input.status != ReadStatus::kFresh) return {Outcome::kMissing, Fault::kLinkLost, {}};

  const DeviceSample& sample = input.sample;
  state.device_state = sample.state;
  const Fault device_fault = device_fault_of(guard, sample);
  const bool answering = state.rearm_left > 0;
  if (answering && (device_fault != Fault::kNone || sample.state == DeviceState::kBrake)) {
    --state.rearm_left;
    return {Outcome::kNotReady, Fault::kNone, {}};
  }
  if (device_fault != Fault::kNone) return {Outcome::kFatal, device_fault, {}};
  if (sample.state == DeviceState::kForce) state.was_in_force = 1;
  state.rearm_left = 0;

  const bool advances = sample.sequence > state.sequence && sample.device_time_ns > state.device_time_ns;
  if (state.based != 0 && !advances) return {Outcome::kMissing, Fault::kInputStale, {}};
  const Finding finding = examine_pose(guard, sample.device_from_tool);
  // A rejected sample counts as new: its repetition is stale.
  state.sequence = sample.sequence;
  state.device_time_ns = sample.device_time_ns;
  return finding;
}

void believe(InputGuard& guard, const Posed& pose) noexcept {
  InputGuard::State& state = guard.state;
  if (state.based != 0) {
    const double rate = 1.0 / (guard.config.period_s * (1.0 + state.missed));
    state.velocity.linear = (pose.position - state.last.position) * rate;
    state.velocity.angular = small_rotation_vector(pose.rotation * conjugate(state.last.rotation)) * rate;
  } else {
    state.velocity = {};
  }
  state.last = state.reported = pose;
  state.missed = state.rejected = 0;
  state.based = 1;
}

// Extrapolates the reported pose over the first missed ticks, with 5/6, 4/6 ... 1/6 of the last velocity, then holds
// it. One lost frame causes no force step, and many lost frames cause no drift.
void extrapolate(InputGuard& guard) noexcept {
  InputGuard::State& state = guard.state;
  if (state.based == 0 || state.missed > kExtrapolateTicks) return;
  const double share = 1.0 - state.missed / (kExtrapolateTicks + 1.0);
  const Vec3d next = state.reported.position + state.velocity.linear * (share * guard.config.period_s);
  if (norm(next) <= 1.05 * guard.config.device.workspace_radius_m) state.reported.position = next;
  const Vec3d turn = state.velocity.angular * (share * guard.config.period_s);
  state.reported.rotation = normalized(quat_from_rotation_vector(turn) * state.reported.rotation);
}

// Counts a tick without an accepted sample; returns the fault if the limit is reached.
Fault count_missed(InputGuard& guard, const Finding& finding) noexcept {
  InputGuard::State& state = guard.state;
  if (state.missed < 0xffffffffu) ++state.missed;
  switch (finding.outcome) {
    case Outcome::kFatal:
      return finding.fault;
    case Outcome::kRejected:
      ++state.rejected;
      return state.rejected >= kRejectedTicks || state.missed >= kFadeOutTicks ? finding.fault : Fault::kNone;
    case Outcome::kMissing:
      if (state.based == 0 && state.first_frame_left > 0) {
        --state.first_frame_left;
        return state.first_frame_left == 0 ? finding.fault : Fault::kNone;
      }
      return state.missed >= kFadeOutTicks ? finding.fault : Fault::kNone;
    default:
      return Fault::kNone;
  }
}

}  // namespace

GuardedInput InputGuard::accept(const DeviceInput& input) noexcept {
  if (state.started == 0) {
    state.started = 1;
    state.first_frame_left = std::max(1u, config.first_frame_ticks);
  }
  GuardedInput out;
  const bool latched = state.fault != Fault::kNone;
  if (latched) {
    if (input.status == ReadStatus::kFresh) state.device_state = input.sample.state;
    if (input.status != ReadStatus::kFresh) out.status |= kFrameMissing;
    if (state.missed < 0xffffffffu) ++state.missed;
    extrapolate(*this);
  } else {
    const bool was_based = state.based != 0;
    const Finding finding = examine(*this, input);
    if (finding.outcome == Outcome::kBelieved) {
      believe(*this, finding.pose);
      out.valid = true;
      out.rebased = !was_based;
    } else {
      state.fault = count_missed(*this, finding);
      extrapolate(*this);
    }
    const bool no_frame = finding.outcome == Outcome::kMissing || finding.fault == Fault::kDeviceUnplugged;
    if (no_frame) out.status |= kFrameMissing;
    if (finding.outcome == Outcome::kRejected) out.status |= kInputRejected;
    if (finding.outcome == Outcome::kNotReady) out.status |= kNotArmed;
  }
  if (state.missed >= kFadingTicks) out.status |= kForceFading;
  out.device_from_tool = state.reported;
  out.device_state = state.device_state;
  out.fault = state.fault;
  out.missed = state.missed;
  out.force_scale = state.based == 0 ? 0.0 : std::max(0.0, 1.0 - state.missed / static_cast<double>(kFadeOutTicks));
  return out;
}

void InputGuard::rearm() noexcept {
  const Posed held = state.reported;
  state = State{};
  state.reported = held;
  state.started = 1;
  state.first_frame_left = kFadeOutTicks;
  state.rearm_left = config.rearm_ticks;
}

}  // namespace tactus::haptics
