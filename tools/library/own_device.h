// Adapts the caller's Device to the interface of the loop: numbers its samples, implements the state machine that the
// project's firmware has, and commands no force that is not finite or not enabled.
//
// Thread: construction, start(), finish() [setup]; read(), write() [rt]: the time of the caller's code plus a constant.
// Frame: the device's. The device outlives this. Faults: those that Device reports; kOutputNotFinite does not occur.
#pragma once

#include "rt/base/result.h"
#include "rt/haptics/device.h"
#include "tactus/device.h"

namespace tactus::library {

// Error: which figure is impossible and what is accepted.
Status check_properties(const DeviceProperties& properties);

class OwnDevice {
 public:
  // `properties`: already checked.
  OwnDevice(Device& device, const DeviceProperties& properties, double period_s) noexcept;

  const haptics::DeviceProperties& properties() const noexcept { return properties_; }
  Status start();
  void read(haptics::DeviceInput& input) noexcept;
  void write(const haptics::DeviceCommand& command) noexcept;
  // Removes the force and stops the device if it was started.
  void finish() noexcept;

  // State that depends on earlier samples and commands; the caller's device has a state of its own.
  struct State {
    std::uint64_t reads{0};
    DeviceSample last{};
    haptics::DeviceSample sample;  // the last fresh one
    haptics::DeviceState state{haptics::DeviceState::kIdle};
    std::uint32_t rearm{0};  // of the last command
  };
  const State& state() const noexcept { return state_; }
  void set_state(const State& state) noexcept { state_ = state; }

 private:
  Device& device_;
  haptics::DeviceProperties properties_;
  double period_s_;
  bool started_{false};
  State state_;
};

static_assert(haptics::HapticDevice<OwnDevice>);

}  // namespace tactus::library
