#include "firmware/device.h"

namespace tactus::firmware {
namespace {

float magnitude(float x) noexcept { return x < 0.0f ? -x : x; }

std::uint8_t first_axis(std::uint32_t axes) noexcept {
  return axes == 0 ? kNoAxis : static_cast<std::uint8_t>(std::countr_zero(axes));
}

std::uint8_t fastest_axis(const AxisValues& speed, const AxisValues& max_speed) noexcept {
  std::uint8_t fastest = 0;
  for (std::uint8_t i = 1; i < kAxes; ++i)
    if (magnitude(speed[i]) * max_speed[fastest] > magnitude(speed[fastest]) * max_speed[i]) fastest = i;
  return fastest;
}

}  // namespace

Device::Device(const DeviceConfig& factory, const Identity& identity) noexcept
    : factory_(factory), accepted_(factory), identity_(identity), controller_(factory.control) {
  apply();
  for (std::uint32_t i = 0; i < self_test_.periods_per_pass(); ++i)
    self_test_.step(accepted_.view(), in_force(), true, true);
}

bool Device::restore(std::span<const std::byte> block) noexcept {
  if (block.empty()) return false;  // nothing was ever saved
  stored_unreadable_ = !read_config_block(block, accepted_);
  if (!stored_unreadable_) apply();
  return !stored_unreadable_;
}

ControllerOutputs Device::step(const ControllerInputs& inputs, std::span<const std::byte> command_frame) noexcept {
  if (changed_) apply();
  time_us_ = inputs.time_us;

  const Encoders::Reading reading = encoders_.update(inputs);
  if (reading.meaning_changed) controller_.rebase(reading.before);
  ControllerInputs calibrated = inputs;
  calibrated.counts = reading.counts;

  const State before = controller_.state();
  const Fault fault_before = controller_.fault();
  const ControllerOutputs outputs = controller_.step(calibrated, command_frame, supervise(reading));

  const std::uint32_t period_us = controller_.config().period_us;
  speed_filter_.update(controller_.speed(), encoders_.config().speed_corner_Hz, period_us);
  log_fault(before, fault_before, reading);
  thermal_.update(outputs.effort, inputs.measured_rise_K, period_us);
  self_test_.step(accepted_.view(), in_force(), reading.fault_axes == 0, inputs.motor_bus_ok);
  if (save_state_ == SaveState::kWriting && !block_waits_) block_waits_ = writer_.advance(in_force());
  return outputs;
}

// Activates the accepted configuration as a whole, between two periods.
void Device::apply() noexcept {
  controller_.configure(accepted_.control);
  encoders_.configure(accepted_.encoders);
  thermal_.configure(accepted_.thermal);
  gravity_ = accepted_.gravity;
  bus_ = accepted_.bus;
  carries_arm_ = gravity_.constant != AxisValues{} || gravity_.amplitude != decltype(gravity_.amplitude){};
  parts_valid_ = is_valid(accepted_.encoders) && is_valid(accepted_.thermal);
  changed_ = false;
}

Supervision Device::supervise(const Encoders::Reading& reading) noexcept {
  Supervision s;
  if (!parts_valid_)
    s.fault = Fault::kBadConfiguration;
  else if (self_test_.is_fault())
    s.fault = Fault::kSelfTest;
  else if (reading.fault_axes != 0)
    s.fault = Fault::kEncoder;
  else if (thermal_.is_too_hot())
    s.fault = Fault::kOverheated;

  const HomingState homing = encoders_.state();
  const bool position_known = homing == HomingState::kHomed || encoders_.config().homing_demanded == 0;
  s.force_allowed = position_known && homing != HomingState::kHoming;
  s.effort_share = thermal_.effort_share();
  if (!position_known) s.limits |= bit_of(Limit::kNotHomed);
  if (homing == HomingState::kHoming) s.limits |= bit_of(Limit::kHoming);
  if (thermal_.is_warm()) s.limits |= bit_of(Limit::kWarm);

  if (carries_arm_ && s.force_allowed) {
    AxisValues coordinates{};
    for (unsigned i = 0; i < kAxes; ++i)
      coordinates[i] = coordinate_of(reading.counts[i], controller_.config().quantum[i]);
    s.support = gravity_effort(gravity_, coordinates);
    s.support_in_idle = gravity_.in_idle != 0;
  }
  return s;
}

void Device::log_fault(State before, Fault fault_before, const Encoders::Reading& reading) noexcept {
  const Fault fault = controller_.fault();
  const bool braked = before != State::kBrake && controller_.state() == State::kBrake && fault != Fault::kNone;
  if (!braked && (fault != Fault::kBadConfiguration || fault == fault_before)) return;

  FaultEntry entry{.fault = fault, .state_before = before, .axis = kNoAxis, .time_us = time_us_, .value = 0.0f};
  switch (fault) {
    case Fault::kOverspeed:
      entry.axis = fastest_axis(controller_.speed(), controller_.config().max_speed);
      entry.value = controller_.speed()[entry.axis];
      break;
    case Fault::kCommandsLost:
      entry.value = static_cast<float>(controller_.missed_commands());
      break;
    case Fault::kEncoder:
      entry.axis = first_axis(reading.fault_axes);
      entry.value = static_cast<float>(encoders_.errors(entry.axis));
      break;
    case Fault::kOverheated:
      entry.axis = static_cast<std::uint8_t>(thermal_.hot_axis());
      entry.value = thermal_.rise_K()[entry.axis];
      break;
    case Fault::kSelfTest:
      entry.value = static_cast<float>(self_test_.failed());
      break;
    default:
      break;
  }
  log_.record(entry);
}

ConfigView Device::in_force() const noexcept {
  return {.control = &controller_.config(),
          .encoders = &encoders_.config(),
          .thermal = &thermal_.config(),
          .gravity = &gravity_,
          .bus = &bus_};
}

std::span<const std::byte> Device::block_to_store() const noexcept {
  return block_waits_ ? writer_.block() : std::span<const std::byte>{};
}

void Device::stored(bool good) noexcept {
  if (!block_waits_) return;
  block_waits_ = false;
  save_state_ = good ? SaveState::kSaved : SaveState::kFailed;
}

}  // namespace tactus::firmware
