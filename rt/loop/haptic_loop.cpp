#include "rt/loop/haptic_loop.h"

#include "rt/physics/overlap.h"

namespace tactus::loop {
namespace {

// Duration of the force ramp after engaging, after a fade and after a lost world: full force changes by 0.15 N per tick
// of 1 ms. The ramp scales the force and does not limit its rate, so it never keeps a force from which the hand has
// already withdrawn.
constexpr double kRecovery_s = 0.2;
constexpr double kRecoveryOfInput_s = 0.1;  // after missed frames: full force again within 0.1 s (hard case 18)
// One or two missed frames are no fade: the force returns as it fell, by a tenth per tick.
constexpr double kMissedShare = 1.0 / haptics::kFadeOutTicks;
// Scene reset: duration of the force fade (full force changes by 0.6 N per tick of 1 ms), then the time in which a
// proxy that starts inside a body is pushed out before it is coupled again.
constexpr double kResetFade_s = 0.05, kResetRest_s = 0.1;
// Overlaps below this share of the scene's thinnest body are not analysed, which saves time in most ticks.
constexpr double kSharesFrom = 0.05;

}  // namespace

HapticLoop::HapticLoop(const LoopConfig& config, std::span<const physics::Body> fixed_bodies)
    : config_(config), sub_world_(config.sub_world, fixed_bodies) {
  guard_.config = {
      .period_s = config.period_s, .device = config.device, .emergency_stop_fault = config.emergency_stop_fault};
  velocity_.config = haptics::VelocityEstimator::Config::of(config.device, config.period_s);
  placement_.config = config.placement;
  passivity_.config = haptics::Passivity::Config::of(
      config.device, config.sub_world.gains.at_hand(config.placement.motion_scale), config.period_s);
  limiter_.config = haptics::ForceLimiter::Config::of(config.device, config.period_s);
}

void HapticLoop::tick(const TickInput& in, TickOutput& out) noexcept TACTUS_NONBLOCKING {
  out = TickOutput{};
  out.tick = state_.tick;
  guard(in.device, out);
  watch_force(in.device);
  adopt(in);
  in.stages(TickStage::kAdopt);
  arm(in.operator_bits, out);
  const haptics::DeviceTarget target = couple(out);
  in.stages(TickStage::kCouple);
  step(target, in, out);
  in.stages(TickStage::kStep);
  shape_force(out);
  command(out);
  ++state_.tick;
}

void HapticLoop::guard(const haptics::DeviceInput& in, TickOutput& out) noexcept {
  input_ = guard_.accept(in);
  out.status |= input_.status;
  if (input_.rebased) {
    velocity_.reset();
    state_.last_tool = input_.device_from_tool;
  }
  if (input_.fault != Fault::kNone && state_.fault == Fault::kNone) state_.fault = input_.fault;
  const double rate = 1.0 / config_.period_s;
  const Posed& now = input_.device_from_tool;
  tool_step_velocity_.linear = (now.position - state_.last_tool.position) * rate;
  tool_step_velocity_.angular = small_rotation_vector(now.rotation * conjugate(state_.last_tool.rotation)) * rate;
  state_.last_tool = now;
}

// Disengages at once, without a fade: a device that is not in FORCE gives no force.
void HapticLoop::watch_force(const haptics::DeviceInput& in) noexcept {
  device_missed_ = 0;
  if (in.status != haptics::ReadStatus::kFresh) return;
  device_missed_ = in.sample.missed_commands;
  if (state_.engaged == 0) return watch_.end();
  const Fault fault = watch_.watch(in.sample);
  if (fault == Fault::kNone || state_.fault != Fault::kNone) return;
  state_.fault = fault;
  state_.engaged = 0;
}

// Arming engages as soon as the device gives valid samples. A fault keeps `armed` and clears `engaged`, so that only a
// re-arm restores the force.
void HapticLoop::arm(std::uint32_t operator_bits, TickOutput& out) noexcept {
  // The device reacts to the rising edge of `rearm`, so that a stuck flag cannot defeat its latch. The flag is cleared
  // when a fault latches, and when the guard accepts samples again: then the device has left BRAKE, or its time for
  // that is over and the next re-arm needs a new edge.
  if (state_.fault != Fault::kNone || input_.valid) state_.rearm = 0;
  if ((operator_bits & kArm) != 0) state_.armed = 1;
  const bool braked = input_.device_state == haptics::DeviceState::kBrake;
  if ((operator_bits & kRearm) != 0 && (state_.fault != Fault::kNone || braked)) {
    state_.fault = Fault::kNone;
    state_.armed = state_.rearm = 1;
    state_.engaged = 0;
    guard_.rearm();
  }
  if ((operator_bits & kEmergencyStopLine) != 0) {
    if (state_.fault == Fault::kNone) state_.fault = Fault::kEmergencyStop;
    state_.engaged = state_.rearm = 0;
  }
  if ((operator_bits & kDisarm) != 0) state_.armed = state_.engaged = 0;  // last: overrides the other requests
  if ((operator_bits & kReset) != 0 && state_.reset == Reset::kNone && sub_world_.exchanges()) {
    state_.reset = Reset::kFading;
    state_.reset_left_s = kResetFade_s;
  }
  if (state_.reset != Reset::kNone) {
    out.status |= kSceneReset;
    reset_scene((operator_bits & kHoldReset) != 0);
  }
  if ((operator_bits & kEnd) != 0 && state_.ending == 0) {
    state_.ending = 1;
    state_.ending_left_s = kEndFade_s;
  }
  if (state_.ending != 0) {
    state_.ending_left_s = std::max(0.0, state_.ending_left_s - config_.period_s);
    if (state_.ending_left_s == 0) state_.armed = state_.engaged = 0;
  }
  const bool ready = input_.valid && input_.device_state != haptics::DeviceState::kBrake;
  const bool may_engage = state_.armed != 0 && state_.fault == Fault::kNone && state_.reset == Reset::kNone && ready;
  if (may_engage && state_.engaged == 0) engage();
  if (state_.engaged == 0 || state_.fault != Fault::kNone) out.status |= kNotArmed;
}

// Clears the clutch offsets, so that every trial starts with the device where the scene places it.
void HapticLoop::reset_scene(bool hold) noexcept {
  state_.reset_left_s -= config_.period_s;
  if (state_.reset == Reset::kFading && (state_.reset_left_s <= 0 || state_.engaged == 0)) {
    state_.engaged = 0;
    if (hold) return;
    placement_.state = {};
    sub_world_.ask_reset(placement_.world_from_target(input_.device_from_tool));
    state_.reset = Reset::kAsked;
  } else if (state_.reset == Reset::kAsked && !sub_world_.awaits_reset()) {
    state_.reset = Reset::kResting;
    state_.reset_left_s = kResetRest_s;
  } else if (state_.reset == Reset::kResting && state_.reset_left_s <= 0) {
    state_.reset = Reset::kNone;
  }
}

// Clutches the device to the proxy, so that the spring starts unloaded. At the first engagement the device is usually
// where the scene places it: if the target is within near_m and near_rad of the proxy, the placement is not changed.
void HapticLoop::engage() noexcept {
  const Posed target = placement_.world_from_target(input_.device_from_tool);
  const Posed& proxy = sub_world_.proxy().pose;
  const double near_m = 4.0 * config_.placement.motion_scale * config_.device.position_quantum_m;
  const double near_rad = 4.0 * config_.device.rotation_quantum_rad;
  const bool in_place = norm(target.position - proxy.position) <= near_m &&
                        norm(small_rotation_vector(target.rotation * conjugate(proxy.rotation))) <= near_rad;
  if (!in_place) placement_.clutch_to(proxy, input_.device_from_tool);
  state_.engaged = 1;
  state_.recovered = 0;
  state_.ramp_s = kRecovery_s;
  watch_.begin(state_.tick + 1);
}

void HapticLoop::adopt(const TickInput& in) noexcept {
  if (in.snapshot == nullptr) return;
  sub_world_.synchronise(*in.snapshot, *in.sink.report);
  state_.next_cycle = in.snapshot->cycle + 1;
  if (in.sink.publish != nullptr) in.sink.publish(in.sink.context, in.snapshot->cycle);
}

// After a latched fault the force fades first (ten ticks); then the coupling disengages.
haptics::DeviceTarget HapticLoop::couple(TickOutput& out) noexcept {
  const Twistd velocity = velocity_.update(input_.device_from_tool);
  if (state_.fault != Fault::kNone && input_.force_scale <= 0.0) state_.engaged = 0;
  haptics::DeviceTarget target;
  target.engaged = state_.engaged != 0;
  target.pose = placement_.world_from_target(input_.device_from_tool);
  target.velocity = placement_.target_twist(velocity);
  out.target = target.pose;
  return target;
}

void HapticLoop::step(const haptics::DeviceTarget& target, const TickInput& in, TickOutput& out) noexcept {
  const haptics::SubWorldStep stepped = sub_world_.step(target, in.sub_steps, in.cut);
  const auto& report = stepped.report;
  out.status |= stepped.status;
  if (in.sub_steps < config_.sub_world.step.sub_steps) out.status |= kSubStepsReduced;
  out.wanted = placement_.device_wrench(stepped.on_device);
  out.proxy = sub_world_.proxy();
  out.members = sub_world_.members();
  out.border = sub_world_.border_contacts();
  out.pairs = report.pairs;
  out.contacts = report.contacts;
  out.points = report.points;
  out.capacity_bits = report.capacity_bits;
  out.dropped = report.dropped;
  out.cut_sweep = report.cut_sweep;
  out.deepest_m = report.deepest_m;
  if (report.deepest_m > kSharesFrom * config_.thinnest_m && config_.thinnest_m > 0)
    out.deepest_share = physics::deepest_overlap(sub_world_.world()).share;
  out.border_work_J = sub_world_.border_work_J() + sub_world_.push_out_J();
  out.corrected_J = sub_world_.corrected_J();
  out.border_tank_J = sub_world_.border_tank_J();
  report_ = report;
  const double recovered = recovered_share(stepped.force_scale, (stepped.status & kWorldFade) != 0);
  double fading = state_.reset == Reset::kFading ? std::max(0.0, state_.reset_left_s / kResetFade_s) : 1.0;
  if (state_.ending != 0) fading = std::min(fading, state_.ending_left_s / kEndFade_s);
  force_scale_ = std::min(state_.missed_share, recovered * fading);
}

// A fade lowers the ramp too: the force returns from the level to which it had faded. The same holds for the device's
// own fade when it misses commands: to the next command it applies its last share of the force, not all of it.
double HapticLoop::recovered_share(double world_scale, bool world_fades) noexcept {
  const bool device_fades = device_missed_ >= haptics::kFadingTicks;
  const double missed = std::min(input_.force_scale, device_fades ? 1.0 - kMissedShare * device_missed_ : 1.0);
  state_.missed_share = std::clamp(missed, 0.0, state_.missed_share + kMissedShare);
  const bool input_fades = (input_.status & kForceFading) != 0 || device_fades;
  double recovered = std::min({1.0, state_.recovered + config_.period_s / state_.ramp_s, world_scale});
  if (input_fades) recovered = std::min(recovered, state_.missed_share);
  if (recovered == 1.0 || world_fades) state_.ramp_s = kRecovery_s;
  if (input_fades && state_.recovered == 1.0) state_.ramp_s = kRecoveryOfInput_s;
  state_.recovered = recovered;
  return recovered;
}

haptics::StoredEnergy HapticLoop::stored_energy(const TickOutput& out) const noexcept {
  const Vec3d stretch = out.target.position - out.proxy.pose.position;
  const Vec3d twist = small_rotation_vector(out.target.rotation * conjugate(out.proxy.pose.rotation));
  return {0.5 * config_.sub_world.gains.stiffness_N_per_m * norm_squared(stretch),
          0.5 * config_.sub_world.gains.stiffness_Nm_per_rad * norm_squared(twist)};
}

void HapticLoop::shape_force(TickOutput& out) noexcept {
  if (state_.fault != Fault::kNone && state_.engaged == 0) force_scale_ = 0;
  // The energy account continues without a coupling, but a former debt is not damped then: not engaged means no force.
  Wrenchd due = passivity_.control(out.wanted, tool_step_velocity_, stored_energy(out));
  if (state_.engaged == 0) due = {};
  if (state_.engaged != 0) out.status |= passivity_.status();
  const auto limited = limiter_.limit(due, force_scale_, haptics::Slew::kNormal);
  out.status |= limited.status;
  if (limited.fault != Fault::kNone) {
    // Our own wrench was not finite: there is nothing to fade, and the coupling disengages.
    if (state_.fault == Fault::kNone) state_.fault = limited.fault;
    state_.engaged = state_.rearm = 0;
  }
  out.command.wrench = limited.wrench;
  passivity_.record_sent(limited.wrench);
  const auto& port = passivity_.state;
  out.device_energy_J = port.translation.in_J - port.translation.out_J + port.rotation.in_J - port.rotation.out_J;
  out.damped_energy_J = port.translation.dissipated_J + port.rotation.dissipated_J;
}

void HapticLoop::command(TickOutput& out) noexcept {
  out.fault = state_.fault;
  out.command.sequence = state_.tick + 1;
  const bool fault_done = state_.fault != Fault::kNone && state_.engaged == 0;
  // A device that refuses FORCE is commanded to IDLE, not BRAKE: a hand may have to move it to its index pulses.
  const bool let_go = state_.fault == Fault::kForceRefused;
  out.command.wanted = fault_done && !let_go ? haptics::DeviceState::kBrake
                       : state_.engaged != 0 ? haptics::DeviceState::kForce
                                             : haptics::DeviceState::kIdle;
  out.command.rearm = state_.rearm;
}

bool HapticLoop::wants_snapshot() const noexcept {
  return sub_world_.exchanges() && (state_.next_cycle == 0 || sub_world_.ticks_in_cycle() >= config_.sub_world.ratio);
}

WorkCounts HapticLoop::counts() const noexcept {
  WorkCounts counts;
  counts.bodies = sub_world_.members();
  counts.pairs = report_.pairs;
  counts.comparisons = report_.comparisons;
  counts.contacts = report_.contacts + kContactsPerJoint * report_.joints;
  counts.points = report_.points + kContactsPerJoint * kPointsPerContact * report_.joints;
  counts.border = sub_world_.border_contacts();
  return counts;
}

std::uint64_t HapticLoop::state_hash() const noexcept { return sub_world_.state_hash(); }

void HapticLoop::save(ByteWriter& out) const noexcept {
  out.put(state_);
  out.put(guard_.state);
  out.put(velocity_.state);
  out.put(placement_.state);
  out.put(passivity_.state);
  out.put(limiter_.state);
  out.put(watch_.state);
  sub_world_.save(out);
}

bool HapticLoop::restore(ByteReader& in) noexcept {
  in.get(state_);
  in.get(guard_.state);
  in.get(velocity_.state);
  in.get(placement_.state);
  in.get(passivity_.state);
  in.get(limiter_.state);
  in.get(watch_.state);
  return sub_world_.restore(in) && in.ok();
}

std::size_t HapticLoop::save_size_bound() const noexcept {
  return sizeof(state_) + sizeof(guard_.state) + sizeof(velocity_.state) + sizeof(placement_.state) +
         sizeof(passivity_.state) + sizeof(limiter_.state) + sizeof(watch_.state) + sub_world_.save_size_bound();
}

}  // namespace tactus::loop
