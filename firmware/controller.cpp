#include "firmware/controller.h"

#include <bit>

namespace tactus::firmware {
namespace {

constexpr State R = State::kReset, I = State::kIdle, F = State::kForce, B = State::kBrake;

// Rows: the state. Columns: the event, in the order of its numbers. BRAKE is left by a re-arm alone, and only when
// nothing more urgent is there: the causes come first in the order of events.
constexpr std::array<std::array<State, kEvents>, kStates> kNext{{
    //  stop bus speed effort lost brake rearm force idle nothing
    {{B, R, R, B, I, B, I, I, I, I}},  // RESET: waits for the supply; any calm period ends it
    {{B, B, B, B, I, B, I, F, I, I}},  // IDLE
    {{B, B, B, B, B, B, F, F, I, F}},  // FORCE
    {{B, B, B, B, B, B, I, B, B, B}},  // BRAKE
}};

constexpr std::uint32_t kSaturated = 0xffffffffu;

bool is_finite(float x) noexcept { return (std::bit_cast<std::uint32_t>(x) & 0x7f800000u) != 0x7f800000u; }
// Far above any motor, far below where a square overflows.
constexpr float kMaxPlausible = 1e6f;
bool is_limit(float x) noexcept { return is_finite(x) && x >= 0.0f && x <= kMaxPlausible; }
float magnitude(float x) noexcept { return x < 0.0f ? -x : x; }
void count_up(std::uint32_t& counter) noexcept { counter += counter != kSaturated ? 1u : 0u; }

Fault fault_of(Event event) noexcept {
  switch (event) {
    case Event::kStopLine:
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
      return Fault::kNone;  // a brake that the host asked for is no fault
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

Controller::Controller(const Config& config) noexcept
    : config_(config), config_valid_(is_valid(config)), missed_(config.brake_frames) {}

ControllerOutputs Controller::step(const ControllerInputs& inputs, std::span<const std::byte> command_frame) noexcept {
  const Reception reception = receive(command_frame);
  bool overspeed = false;
  const AxisValues speed = speed_.update(inputs.counts, inputs.time_us, config_.period_us, config_.quantum);
  for (unsigned i = 0; i < kAxes; ++i) overspeed = overspeed || magnitude(speed[i]) > config_.max_speed[i];

  if (config_valid_) {
    const Event event = event_of(inputs, reception, overspeed);
    enter(next_state(state_, event), event);
  } else {
    fault_ = Fault::kBadConfiguration;
  }

  ControllerOutputs outputs;
  limits_ = 0;
  outputs.effort = limited_effort();
  outputs.brake = state_ == State::kReset || state_ == State::kBrake;
  if (inputs.stop_line) limits_ |= bit_of(Limit::kStopLine);
  if (!inputs.motor_bus_ok) limits_ |= bit_of(Limit::kMotorBusLow);

  const StateFrame frame{state_,
                         inputs.buttons,
                         static_cast<std::uint8_t>(missed_ < 255 ? missed_ : 255u),
                         static_cast<std::uint16_t>(fault_),
                         limits_,
                         ++state_sequence_,
                         newest_command_,
                         inputs.time_us,
                         inputs.counts};
  encode_state(frame, outputs.state_frame);
  return outputs;
}

Controller::Reception Controller::receive(std::span<const std::byte> bytes) noexcept {
  Reception reception;
  CommandFrame frame;
  const bool link_was_silent = missed_ >= config_.brake_frames;
  count_up(missed_);  // taken back below by the one kind of frame that feeds the watchdog
  if (bytes.empty()) return reception;

  last_decode_error_ = decode_command(bytes, frame);
  if (last_decode_error_ != DecodeError::kNone) {
    count_up(refused_);
    return reception;
  }
  for (const float effort : frame.effort) reception.effort_not_finite |= !is_finite(effort);
  const bool starts_sequence = link_was_silent || !sequence_known_;
  if (reception.effort_not_finite || (!starts_sequence && !is_newer(frame.sequence, newest_command_))) {
    count_up(refused_);
    return reception;
  }

  newest_command_ = frame.sequence, sequence_known_ = true;
  missed_ = 0;
  if (starts_sequence) {
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

Event Controller::event_of(const ControllerInputs& inputs, const Reception& reception, bool overspeed) const noexcept {
  if (inputs.stop_line) return Event::kStopLine;
  if (!inputs.motor_bus_ok) return Event::kMotorBus;
  if (overspeed) return Event::kOverspeed;
  if (reception.effort_not_finite) return Event::kEffortNotFinite;
  if (missed_ >= config_.brake_frames) return Event::kCommandsLost;
  if (!reception.accepted) return Event::kNothing;
  if (reception.wanted == State::kBrake) return Event::kWantBrake;
  if (reception.rearm_edge) return Event::kRearm;
  return reception.wanted == State::kForce ? Event::kWantForce : Event::kWantIdle;
}

void Controller::enter(State next, Event event) noexcept {
  if (next == State::kBrake && state_ != State::kBrake) fault_ = fault_of(event);  // the first cause is the one kept
  if (next != State::kBrake && state_ == State::kBrake) fault_ = Fault::kNone;
  state_ = next;
}

AxisValues Controller::limited_effort() noexcept {
  if (state_ != State::kForce) return {};
  AxisValues effort = commanded_;
  limit_group(effort, 0, config_.max_force_N, Limit::kForce);
  limit_group(effort, 3, config_.max_torque_Nm, Limit::kTorque);
  if (missed_ >= config_.fade_frames) {
    // Linear, from just below the whole effort at `fade_frames` to zero at `brake_frames`.
    const auto left = static_cast<float>(config_.brake_frames - missed_);
    const float fade = left / static_cast<float>(config_.brake_frames - config_.fade_frames + 1);
    for (float& e : effort) e *= fade;
    limits_ |= bit_of(Limit::kFading);
  }
  return effort;
}

// Three axes are scaled together, so that the direction that the host chose is kept.
void Controller::limit_group(AxisValues& effort, unsigned first, float max_norm, Limit norm_limit) noexcept {
  float scale = 1.0f;
  for (unsigned i = first; i < first + 3; ++i) {
    const float wanted = magnitude(effort[i]);
    if (wanted <= config_.max_effort[i]) continue;
    limits_ |= axis_limit_bit(i);
    const float axis_scale = config_.max_effort[i] / wanted;
    if (axis_scale < scale) scale = axis_scale;
  }
  float norm_squared = 0.0f;
  for (unsigned i = first; i < first + 3; ++i) {
    effort[i] *= scale;
    norm_squared += effort[i] * effort[i];
  }
  if (norm_squared > max_norm * max_norm) {
    limits_ |= bit_of(norm_limit);
    const float norm_scale = max_norm / __builtin_sqrtf(norm_squared);
    for (unsigned i = first; i < first + 3; ++i) effort[i] *= norm_scale;
  }
  // Rounding may leave a last bit above the motor's limit.
  for (unsigned i = first; i < first + 3; ++i) {
    const float limit = config_.max_effort[i];
    effort[i] = effort[i] > limit ? limit : (effort[i] < -limit ? -limit : effort[i]);
  }
}

}  // namespace tactus::firmware
