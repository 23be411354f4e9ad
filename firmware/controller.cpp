#include "firmware/controller.h"

#include <bit>

namespace tactus::firmware {
namespace {

constexpr State R = State::kReset, I = State::kIdle, F = State::kForce, B = State::kBrake;

// Rows: the state. Columns: the event, in the order of its numbers. Only a re-arm leaves BRAKE, and only without a more
// urgent event: all causes of BRAKE precede it in the order of events.
constexpr std::array<std::array<State, kEvents>, kStates> kNext{{
    //  stop bus speed supervision effort lost brake rearm force idle nothing
    {{B, R, R, B, B, I, B, I, I, I, I}},  // RESET: waits for the supply; any calm period ends it
    {{B, B, B, B, B, I, B, I, F, I, I}},  // IDLE
    {{B, B, B, B, B, B, B, F, F, I, F}},  // FORCE
    {{B, B, B, B, B, B, B, I, B, B, B}},  // BRAKE
}};

constexpr std::uint32_t kSaturated = 0xffffffffu;

bool is_finite(float x) noexcept { return (std::bit_cast<std::uint32_t>(x) & 0x7f800000u) != 0x7f800000u; }
// Far above any motor's effort, far below the overflow of a square.
constexpr float kMaxPlausible = 1e6f;
bool is_limit(float x) noexcept { return is_finite(x) && x >= 0.0f && x <= kMaxPlausible; }
// N or N m: smaller efforts are set to zero, before and after each scaling. Their squares would underflow: they would
// pass any norm limit, and would not count as part of the base.
constexpr float kMinEffort = 1e-15f;

float magnitude(float x) noexcept { return x < 0.0f ? -x : x; }
void count_up(std::uint32_t& counter) noexcept { counter += counter != kSaturated ? 1u : 0u; }

// The s in [0, 1] with |base + s (sum - base)| = max_norm. Precondition: |base| <= max_norm < |sum|.
float share_within_norm(const float* base, const float* sum, float sum_squared, float max_norm) noexcept {
  float base_squared = 0.0f, step_squared = 0.0f;
  for (unsigned i = 0; i < 3; ++i) {
    const float step = sum[i] - base[i];
    base_squared += base[i] * base[i];
    step_squared += step * step;
  }
  if (base_squared == 0.0f) return max_norm / __builtin_sqrtf(sum_squared);
  const float room = max_norm * max_norm - base_squared;
  if (!(room > 0.0f) || !(step_squared > 0.0f)) return 0.0f;
  // With t = s |step| and the unit vector d along the step: t^2 + 2 t (base . d) + |base|^2 = max_norm^2. No powers
  // above the second: a fourth power underflows at 1e-10 N.
  const float length = __builtin_sqrtf(step_squared);
  float along = 0.0f;
  for (unsigned i = 0; i < 3; ++i) along += base[i] * ((sum[i] - base[i]) / length);
  const float root = __builtin_sqrtf(along * along + room);
  const float share = (along > 0.0f ? room / (root + along) : root - along) / length;  // no cancellation
  return share < 0.0f ? 0.0f : (share > 1.0f ? 1.0f : share);
}

Fault fault_of(Event event, Fault supervision_fault) noexcept {
  switch (event) {
    case Event::kSupervision:
      return supervision_fault;
    case Event::kEmergencyStop:
      return Fault::kEmergencyStop;
    case Event::kMotorBus:
      return Fault::kMotorBus;
    case Event::kOverspeed:
      return Fault::kOverspeed;
    case Event::kEffortNotFinite:
      return Fault::kEffortNotFinite;
    case Event::kCommandsLost:
      return Fault::kCommandsLost;
    default:
      return Fault::kNone;  // a BRAKE requested by the host is no fault
  }
}

}  // namespace

bool is_valid(const Config& config) noexcept {
  bool valid = config.period_us > 0 && config.fade_frames > 0 && config.fade_frames < config.brake_frames &&
               is_limit(config.max_force_N) && is_limit(config.max_torque_Nm);
  for (unsigned i = 0; i < kAxes; ++i) {
    valid = valid && is_limit(config.quantum[i]) && config.quantum[i] > 0.0f;
    valid = valid && is_limit(config.max_effort[i]);
    valid = valid && is_limit(config.max_speed[i]) && config.max_speed[i] > 0.0f;
  }
  return valid;
}

State next_state(State state, Event event) noexcept {
  return kNext[static_cast<std::size_t>(state)][static_cast<std::size_t>(event)];
}

float watchdog_share(std::uint32_t missed, const Config& config) noexcept {
  if (missed < config.fade_frames) return 1.0f;
  if (missed >= config.brake_frames) return 0.0f;
  const auto left = static_cast<float>(config.brake_frames - missed);
  return left / static_cast<float>(config.brake_frames - config.fade_frames + 1);
}

Controller::Controller(const Config& config) noexcept
    : config_(config), config_valid_(is_valid(config)), missed_(config.brake_frames) {}

void Controller::configure(const Config& config) noexcept {
  const bool was_valid = config_valid_;
  config_ = config;
  config_valid_ = is_valid(config);
  if (!was_valid && config_valid_) fault_ = Fault::kNone;
}

ControllerOutputs Controller::step(const ControllerInputs& inputs, std::span<const std::byte> command_frame,
                                   const Supervision& supervision) noexcept {
  hear(command_frame);
  const Reception reception = receive();
  bool overspeed = false;
  speed_ = speed_meter_.update(inputs.counts, inputs.time_us, config_.period_us, config_.quantum);
  for (unsigned i = 0; i < kAxes; ++i) overspeed = overspeed || magnitude(speed_[i]) > config_.max_speed[i];

  if (config_valid_) {
    const Event event = event_of(inputs, reception, supervision, overspeed);
    enter(next_state(state_, event), event, supervision.fault);
  } else {
    state_ = State::kReset;
    fault_ = Fault::kBadConfiguration;
  }

  ControllerOutputs outputs;
  limits_ = supervision.limits;
  outputs.effort = limited_effort(supervision);
  outputs.brake = state_ == State::kReset || state_ == State::kBrake;
  if (inputs.emergency_stop) limits_ |= bit_of(Limit::kEmergencyStop);
  if (!inputs.motor_bus_ok) limits_ |= bit_of(Limit::kMotorBusLow);
  if (!idle_wanted_) limits_ |= bit_of(Limit::kIdleFirst);

  const StateFrame frame{.state = state_,
                         .buttons = inputs.buttons,
                         .missed_commands = static_cast<std::uint8_t>(missed_ < 255 ? missed_ : 255u),
                         .fault = static_cast<std::uint16_t>(fault_),
                         .limits = limits_,
                         .sequence = ++state_sequence_,
                         .echoed_sequence = newest_command_,
                         .time_us = inputs.time_us,
                         .counts = inputs.counts};
  encode_state(frame, outputs.state_frame);
  return outputs;
}

void Controller::hear(std::span<const std::byte> bytes) noexcept {
  if (bytes.empty()) return;
  CommandFrame frame;
  last_decode_error_ = decode_command(bytes, frame);
  const bool whole = last_decode_error_ == DecodeError::kNone;
  if (!whole || (!starts_sequence() && !is_newer(frame.sequence, newest_command_))) return count_up(refused_);
  bool finite = true;
  for (const float effort : frame.effort) finite = finite && is_finite(effort);
  if (!finite) {
    heard_.effort_not_finite = true;
    return count_up(refused_);
  }
  // At the start of a sequence there is no reference: the last received frame counts.
  const bool older = heard_.acceptable && !starts_sequence() && !is_newer(frame.sequence, heard_.newest.sequence);
  if (older) return count_up(refused_);
  heard_.newest = frame;
  heard_.acceptable = true;
}

Controller::Reception Controller::receive() noexcept {
  Reception reception;
  const Heard heard = heard_;
  heard_ = {};
  reception.effort_not_finite = heard.effort_not_finite;
  const bool starts = starts_sequence();
  count_up(missed_);  // reset below if a frame is accepted
  if (!heard.acceptable) return reception;

  const CommandFrame& frame = heard.newest;
  newest_command_ = frame.sequence;
  sequence_known_ = true;
  missed_ = 0;
  if (frame.wanted == State::kIdle) idle_wanted_ = true;
  if (starts) {
    rearm_before_ = true;
    return reception;
  }
  reception.accepted = true;
  reception.wanted = frame.wanted;
  reception.rearm_edge = frame.rearm && !rearm_before_;
  rearm_before_ = frame.rearm;
  commanded_ = frame.effort;
  return reception;
}

Event Controller::event_of(const ControllerInputs& inputs, const Reception& reception, const Supervision& supervision,
                           bool overspeed) const noexcept {
  if (inputs.emergency_stop) return Event::kEmergencyStop;
  if (!inputs.motor_bus_ok) return Event::kMotorBus;
  if (overspeed) return Event::kOverspeed;
  if (supervision.fault != Fault::kNone) return Event::kSupervision;
  if (reception.effort_not_finite) return Event::kEffortNotFinite;
  if (missed_ >= config_.brake_frames) return Event::kCommandsLost;
  const bool force_must_end = state_ == State::kForce && !supervision.force_allowed;
  if (!reception.accepted) return force_must_end ? Event::kWantIdle : Event::kNothing;
  if (reception.wanted == State::kBrake) return Event::kWantBrake;
  if (reception.rearm_edge) return Event::kRearm;
  const bool force_allowed = supervision.force_allowed && idle_wanted_;
  return reception.wanted == State::kForce && force_allowed ? Event::kWantForce : Event::kWantIdle;
}

void Controller::enter(State next, Event event, Fault supervision_fault) noexcept {
  // Keep the first cause.
  if (next == State::kBrake && state_ != State::kBrake) fault_ = fault_of(event, supervision_fault);
  if (next != State::kBrake && state_ == State::kBrake) fault_ = Fault::kNone;
  state_ = next;
}

// The arm's support has priority; the command's efforts are added as far as the limits allow. Only the command's part
// fades, so the arm does not drop while the host is late. The set of efforts within the limits is convex, so all
// efforts between the two sums are within the limits.
AxisValues Controller::limited_effort(const Supervision& supervision) noexcept {
  const bool supported = state_ == State::kForce || (state_ == State::kIdle && supervision.support_in_idle);
  AxisValues support{};
  if (supported && supervision.support != AxisValues{})
    support = add_within_limits({}, supervision.support, supervision.effort_share);
  if (state_ != State::kForce) return support;

  AxisValues effort = add_within_limits(support, commanded_, supervision.effort_share);
  if (missed_ >= config_.fade_frames) {
    const float fade = watchdog_share(missed_, config_);
    for (unsigned i = 0; i < kAxes; ++i) effort[i] = support[i] + fade * (effort[i] - support[i]);
    limits_ |= bit_of(Limit::kFading);
  }
  return effort;
}

// base + s extra, with the largest s in [0, 1] that the motors and the two norms allow. Three axes share one s, which
// keeps the direction of `extra`. Precondition: `base` is within the limits.
AxisValues Controller::add_within_limits(const AxisValues& base, const AxisValues& extra,
                                         const AxisValues& share) noexcept {
  AxisValues sum{};
  for (unsigned first = 0; first < kAxes; first += 3) {
    const float max_norm = first == 0 ? config_.max_force_N : config_.max_torque_Nm;
    AxisValues max_effort{};
    float scale = 1.0f, norm_squared = 0.0f;
    for (unsigned i = first; i < first + 3; ++i) {
      max_effort[i] = config_.max_effort[i] * share[i];
      const float wanted = magnitude(extra[i]);
      const float room = extra[i] < 0.0f ? max_effort[i] + base[i] : max_effort[i] - base[i];
      if (wanted <= room) continue;
      limits_ |= axis_limit_bit(i);
      const float axis_scale = room / wanted;
      if (axis_scale < scale) scale = axis_scale;
    }
    for (unsigned i = first; i < first + 3; ++i) {
      sum[i] = base[i] + extra[i] * scale;
      if (magnitude(sum[i]) < kMinEffort) sum[i] = 0.0f;
      norm_squared += sum[i] * sum[i];
    }
    if (norm_squared > max_norm * max_norm) {
      limits_ |= bit_of(first == 0 ? Limit::kForce : Limit::kTorque);
      const float norm_scale = share_within_norm(&base[first], &sum[first], norm_squared, max_norm);
      for (unsigned i = first; i < first + 3; ++i) sum[i] = base[i] + (sum[i] - base[i]) * norm_scale;
    }
    // Rounding may exceed the motor's limit by one bit.
    for (unsigned i = first; i < first + 3; ++i) {
      const float limit = max_effort[i];
      sum[i] = sum[i] > limit ? limit : (sum[i] < -limit ? -limit : sum[i]);
      if (magnitude(sum[i]) < kMinEffort) sum[i] = 0.0f;
    }
  }
  return sum;
}

}  // namespace tactus::firmware
