// Opens the device of a run by its class (hal/device_class.h; none when a tape is replayed) and the lines of --gpio.
//
// A real device is described by a device file or the scene's profile; before it is driven, its identity, version and
// limits are compared with that description. Thread: normal, before the loop runs.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "hal/device_class.h"
#include "hal/gpio/hand_lines.h"
#include "tools/session/run_options.h"

namespace tactus::session {

// Placeholder device for a replay: has the device's properties and returns empty input.
class TapedDevice {
 public:
  explicit TapedDevice(const haptics::DeviceProperties& properties) : properties_(properties) {}
  const haptics::DeviceProperties& properties() const noexcept { return properties_; }
  void read(haptics::DeviceInput& input) noexcept { input = {}; }
  void write(const haptics::DeviceCommand&) noexcept {}

 private:
  haptics::DeviceProperties properties_;
};

// Hardware opened for a run.
struct Hardware {
  std::unique_ptr<hal::AnyDevice> device;
  bool real{false};                      // its class keeps real time: it receives IDLE before it is armed
  std::string identity;                  // of a real device, as text; empty otherwise
  std::function<Status()> same_device;   // compares the device with the one opened; null: none
  std::unique_ptr<hal::HandLines> gpio;  // null without --gpio
};

// Opens the real device and the lines that the options name; otherwise the members are empty. Error, one line: what the
// machine lacks or the device reports, and the remedy.
Result<Hardware> open_hardware(const RunOptions& options, const hal::DeviceProfile& profile);
// Of several hands: their devices first, then the lines that `gpio` names, which all of them share. `profiles`: by
// hand.
Result<std::vector<Hardware>> open_hardware(const std::vector<RunOptions>& options,
                                            const std::vector<hal::DeviceProfile>& profiles, const std::string& gpio);

// Makes a device without hardware of the class that the options name, or the placeholder for a replay.
Result<std::unique_ptr<hal::AnyDevice>> make_simulated(const RunOptions& options, const hal::DeviceProfile& profile,
                                                       const hal::HandModel& hand, const hal::FaultScript& faults);

}  // namespace tactus::session
