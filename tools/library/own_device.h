// A Device of the caller's as the loop wants one: numbers its samples, keeps the state machine that a device with the
// project's firmware keeps itself, and sees to it that no force is asked of it that is not finite or not wanted.
//
// Thread: construction, start(), finish() [setup]; read(), write() [rt]: what the caller's own code costs, and constant
// time. Frame: the device's. The device outlives this. Faults: what Device reports; kOutputNotFinite never comes here.
#pragma once

#include "rt/base/result.h"
#include "rt/haptics/device.h"
#include "tactus/device.h"

namespace tactus::library {

// Which figure is impossible, what is accepted; good else.
Status check_properties(const DeviceProperties& properties);

class OwnDevice {
 public:
  // `properties`: checked.
  OwnDevice(Device& device, const DeviceProperties& properties, double period_s) noexcept;

  const haptics::DeviceProperties& properties() const noexcept { return properties_; }
  Status start();
  void read(haptics::DeviceInput& input) noexcept;
  void write(const haptics::DeviceCommand& command) noexcept;
  // No force any more, and the device is told to stop, where it was started.
  void finish() noexcept;

 private:
  Device& device_;
  haptics::DeviceProperties properties_;
  double period_s_;
  bool started_{false};
  std::uint64_t reads_{0};
  DeviceSample last_{};
  haptics::DeviceSample sample_;  // the last one that came
  haptics::DeviceState state_{haptics::DeviceState::kIdle};
  std::uint32_t rearm_{0};  // of the last command
};

static_assert(haptics::HapticDevice<OwnDevice>);

}  // namespace tactus::library
