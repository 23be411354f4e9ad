// A device that is on, as a host finds it that has opened it: told to be IDLE once, without which it gives no FORCE,
// and left alone since, so that the next command starts a sequence. Its clock stands at 0 meanwhile. Thread: [setup].
// Frame: none; counts are the axes'.
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
