// The host's end of the wire: state frames become DeviceSamples, DeviceCommands become command frames.
//
// Every device uses it, simulated or real. Counts become a pose here, once; a wrench becomes axis efforts at the
// coordinates of the newest decoded sample. 32-bit sequences of the wire continue as 64-bit ones.
// Frame: the device's. Units: SI. Thread: [rt], the haptic thread; no allocation, bounded.
#pragma once

#include "firmware/protocol.h"
#include "hal/kinematics/kinematics.h"
#include "rt/haptics/device.h"

namespace tactus::hal {

class FrameCodec {
 public:
  // `quantum`: m or rad per count. Without rotation the torque of a command is left out.
  FrameCodec(const Kinematics& kinematics, const AxisVector& quantum, bool has_rotation) noexcept
      : kinematics_(kinematics), quantum_(quantum), has_rotation_(has_rotation) {}

  // On an error `sample` is left as it was.
  [[nodiscard]] firmware::DecodeError decode(std::span<const std::byte> bytes, haptics::DeviceSample& sample) noexcept;

  // NaN goes through: the firmware refuses it and says so. Wanting kReset is wanting kIdle.
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
