#include "hal/frame_codec.h"

namespace tactus::hal {
namespace {

using haptics::DeviceState;

static_assert(static_cast<int>(DeviceState::kReset) == static_cast<int>(firmware::State::kReset) &&
              static_cast<int>(DeviceState::kIdle) == static_cast<int>(firmware::State::kIdle) &&
              static_cast<int>(DeviceState::kForce) == static_cast<int>(firmware::State::kForce) &&
              static_cast<int>(DeviceState::kBrake) == static_cast<int>(firmware::State::kBrake));

// The 64-bit sequence number nearest to `known` whose low 32 bits are `low`.
std::uint64_t continued(std::uint64_t known, std::uint32_t low) noexcept {
  const auto step = static_cast<std::int32_t>(low - static_cast<std::uint32_t>(known));
  const auto back = static_cast<std::uint64_t>(-static_cast<std::int64_t>(step));
  if (step < 0 && back > known) return low;  // would be negative
  return known + static_cast<std::uint64_t>(static_cast<std::int64_t>(step));
}

}  // namespace

firmware::DecodeError FrameCodec::decode(std::span<const std::byte> bytes, haptics::DeviceSample& sample) noexcept {
  firmware::StateFrame frame;
  if (const auto error = firmware::decode_state(bytes, frame); error != firmware::DecodeError::kNone) return error;
  for (unsigned i = 0; i < kAxisCount; ++i) coordinates_[i] = firmware::coordinate_of(frame.counts[i], quantum_[i]);
  state_sequence_ = state_seen_ ? continued(state_sequence_, frame.sequence) : frame.sequence;
  state_seen_ = true;

  sample.sequence = state_sequence_;
  sample.device_time_ns = frame.time_us * 1000;
  sample.device_from_tool = kinematics_.pose_of(coordinates_);
  sample.state = static_cast<DeviceState>(frame.state);
  sample.device_fault = frame.fault;
  sample.limits = frame.limits;
  sample.buttons = frame.buttons;
  sample.missed_commands = frame.missed_commands;
  sample.echoed_sequence = continued(command_sequence_, frame.echoed_sequence);
  return firmware::DecodeError::kNone;
}

void FrameCodec::encode(const haptics::DeviceCommand& command,
                        std::span<std::byte, firmware::kCommandFrameSize> bytes) noexcept {
  Wrenchd wrench = command.wrench;
  if (!has_rotation_) wrench.torque = {};
  const AxisVector effort = kinematics_.efforts_of(coordinates_, wrench);
  firmware::CommandFrame frame;
  const bool resets = command.wanted == DeviceState::kReset;
  frame.wanted = resets ? firmware::State::kIdle : static_cast<firmware::State>(command.wanted);
  frame.rearm = command.rearm != 0;
  frame.sequence = static_cast<std::uint32_t>(command.sequence);
  for (unsigned i = 0; i < kAxisCount; ++i) frame.effort[i] = static_cast<float>(effort[i]);
  command_sequence_ = command.sequence;
  firmware::encode_command(frame, bytes);
}

}  // namespace tactus::hal
