// The host's frame codec: decodes state frames into DeviceSamples, encodes DeviceCommands into command frames.
//
// Every device on frames uses it, simulated or real. It converts encoder counts to a pose, and a wrench to axis efforts
// at the coordinates of the newest decoded sample. The 32-bit sequence numbers of the wire are extended to 64 bits.
// Frame: the device's. Units: SI. Thread: [rt], the haptic thread; no allocation, bounded.
#pragma once

#include "firmware/protocol.h"
#include "hal/kinematics/kinematics.h"
#include "rt/haptics/device.h"

namespace tactus::hal {

class FrameCodec {
 public:
  // `quantum`: m or rad per count. Without rotation the torque of a command is ignored.
  FrameCodec(const Kinematics& kinematics, const AxisVector& quantum, bool has_rotation) noexcept
      : kinematics_(kinematics), quantum_(quantum), has_rotation_(has_rotation) {}

  // On an error `sample` is unchanged.
  [[nodiscard]] firmware::DecodeError decode(std::span<const std::byte> bytes, haptics::DeviceSample& sample) noexcept;

  // NaN is encoded as it is: the firmware rejects it and reports that. A wanted kReset is encoded as kIdle.
  void encode(const haptics::DeviceCommand& command, std::span<std::byte, firmware::kCommandFrameSize> bytes) noexcept;

 private:
  Kinematics kinematics_;
  AxisVector quantum_;
  bool has_rotation_;
  AxisVector coordinates_{};           // of the newest sample
  std::uint64_t state_sequence_{0};    // of the newest sample
  std::uint64_t command_sequence_{0};  // of the newest command
  bool state_seen_{false};
};

}  // namespace tactus::hal
