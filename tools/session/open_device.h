// The device that a run asks for, opened: simulated, on USB, on CAN; or none, where a tape says what the device said.
// With it the lines of --gpio.
//
// A real device is described by a device file or the scene's profile; before it is driven, its identity, version and
// limits are compared with that description. Thread: normal, before the loop runs.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "hal/any_device.h"
#include "hal/gpio/gpio_lines.h"
#include "hal/hand.h"
#include "hal/simulated_device.h"
#include "tools/session/device_choice.h"
#include "tools/session/run_options.h"

namespace tactus::session {

// The device on `link`, read now; what is returned reads it again and compares. One line on an error. The link outlives
// it.
Result<std::function<Status()>> remember_device(hal::AnyLink& link);

// Stands in where a tape is replayed: what the loop must know of the device, and nothing that comes from it.
class TapedDevice {
 public:
  explicit TapedDevice(const haptics::DeviceProperties& properties) : properties_(properties) {}
  const haptics::DeviceProperties& properties() const noexcept { return properties_; }
  void read(haptics::DeviceInput& input) noexcept { input = {}; }
  void write(const haptics::DeviceCommand&) noexcept {}

 private:
  haptics::DeviceProperties properties_;
};

// What a run holds of the machine's.
struct Hardware {
  std::unique_ptr<hal::AnyDevice> device;
  std::string identity;                  // of a real device, for people; empty else
  std::function<Status()> same_device;   // is it still what it was when it was opened? Asks it; null: nothing to ask
  std::unique_ptr<hal::GpioLines> gpio;  // null without --gpio
};

// The real device and the lines, where the options ask for them; else empty. One line on an error: what the machine
// lacks or what the device says, and what to do.
Result<Hardware> open_hardware(const RunOptions& options, const hal::DeviceProfile& profile);

// In place of a real device: the simulated one, or the one of a tape.
Result<std::unique_ptr<hal::AnyDevice>> make_simulated(const RunOptions& options, const hal::DeviceProfile& profile,
                                                       const hal::HandModel& hand, const hal::FaultScript& faults);

}  // namespace tactus::session
