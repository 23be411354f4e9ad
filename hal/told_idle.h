// Creates a simulated device in the state in which a host finds it after opening it: it has received one IDLE command,
// which it requires before FORCE, and no command since, so that the next command starts a sequence. Its clock is still
// at 0. Thread: [setup]. Frame: none; counts are encoder counts of the axes.
#pragma once

#include "firmware/device.h"

namespace tactus::hal {

inline firmware::Device told_idle(const firmware::Config& config, const firmware::AxisCounts& counts) noexcept {
  firmware::Device device(config);
  std::array<std::byte, firmware::kCommandFrameSize> idle{};
  firmware::encode_command({}, idle);
  device.hear(idle);
  firmware::ControllerInputs inputs;
  inputs.counts = counts;
  for (unsigned period = 0; period <= config.brake_frames; ++period) (void)device.step(inputs, {});
  return device;
}

}  // namespace tactus::hal
