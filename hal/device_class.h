// Device classes by name: what `--device NAME[:ADDRESS]` chooses, in a configuration file too.
//
// A class is one constant DeviceClass in one file of hal/classes/, and one line in hal/device_list.h. The commands run,
// timing, hil and doctor then accept its name. Thread: [setup] and normal threads. Units in the names.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "hal/any_device.h"
#include "hal/any_link.h"
#include "hal/fault_injection.h"
#include "hal/hand.h"
#include "hal/profiles.h"

namespace tactus::hal {

// What a class may use to open its device. The references must be valid during the call only.
struct DeviceRequest {
  std::string address;           // the text after the colon; empty: none
  const DeviceProfile& profile;  // of the device that is expected
  std::int64_t period_ns{1'000'000};
  // For classes without hardware: who holds the tool, what goes wrong, and the seed of random faults.
  const HandModel& hand;
  const FaultScript& faults;
  std::uint64_t seed{1};
};

// A property that cannot be checked through this device, under the check of `tactus hil` that comes nearest to it.
struct NotChecked {
  std::string check;
  std::string what;
};

struct OpenedDevice {
  std::unique_ptr<AnyDevice> device;
  std::string identity;                    // as text, for the summary; empty: nothing to tell
  std::function<Status()> same_device{};   // compares the device with the one opened; null: it cannot change
  std::vector<NotChecked> not_checked{};   // for `tactus hil`
  std::function<std::string()> trouble{};  // why no samples come, as a half line; empty or null: nothing is known
};

struct OpenedLink {
  std::unique_ptr<AnyLink> link;
  std::string name;  // readable: port and serial number, or interface and node
};

struct DeviceClass {
  std::string_view name;
  std::string_view forms;  // what --device accepts, for messages and help: "usb, usb:SERIAL"
  std::string_view what;   // one line for a list of the classes
  // Hardware: runs in real time and continues after the run. So there is no virtual time and no fault script, and the
  // operator is asked before motors move.
  bool real{false};
  // What is wrong with the address, without the address itself; good: it is acceptable. Never touches hardware.
  Status (*check_address)(std::string_view address){nullptr};
  // Opens the device. Error, one line: what the machine lacks or the device reports, and the remedy.
  Result<OpenedDevice> (*open)(const DeviceRequest& request){nullptr};
  // The link alone, of classes that speak firmware/PROTOCOL.md; null for the others. Errors as open().
  Result<OpenedLink> (*open_link)(const DeviceRequest& request){nullptr};
  // The resources of this machine that a device uses, such as an interface or a serial number: two hands must not use
  // the same one. An empty string means any device of the class. Null: a simulated device, of which there may be any
  // number. `each_its_own`: how to name each hand's own device, for messages.
  std::vector<std::string> (*takes)(std::string_view address, const DeviceDescription& description){nullptr};
  std::string_view each_its_own{};
  // The device's properties are its own: a description would have no effect.
  bool describes_itself{false};
  // The scene's [hand] holds the tool.
  bool hand_by_script{false};
  // What `tactus doctor` examines: USB, or these CAN interfaces. Null: no CAN.
  bool usb{false};
  std::vector<std::string> (*can_interfaces)(std::string_view address){nullptr};
  // One line for `tactus doctor`: what the class needs and this machine has, such as a maker's library. Opens no
  // device. Null: the class needs nothing. Error, one line: what is missing.
  Result<std::string> (*look)(std::string_view address){nullptr};
  // For a device whose force gain, motor values per N m, its user measures (`tactus hil --calibrate`): returns the gain
  // that an address contains, and the address with another gain. Null: there is no gain to measure.
  double (*force_gain)(std::string_view address){nullptr};
  std::string (*with_force_gain)(std::string_view address, double gain_per_Nm){nullptr};
};

// In the order of hal/device_list.h.
std::span<const DeviceClass* const> device_classes() noexcept;

// Null for an unknown name.
const DeviceClass* find_device_class(std::string_view name) noexcept;

// "sim, usb, usb:SERIAL, can:IFACE, ...": what --device accepts.
std::string accepted_devices();
// A line for each class, for help: what --device accepts and what device that is.
std::string described_devices();

struct DeviceChoice {
  const DeviceClass* device_class{nullptr};
  std::string address;
};

// Describes what is wrong with NAME[:ADDRESS], without accepted_devices(); empty: nothing is.
std::string device_mistake(const std::string& text);
// Splits NAME[:ADDRESS] and checks both. Error, one line: what was given and what is accepted.
Result<DeviceChoice> choose_device(const std::string& text);

// Of a device that --device names `text`. Errors, one line each: the device does not run in virtual time; the device
// ignores a description.
Status check_virtual_time(const DeviceClass& device_class, const std::string& text);
Status check_described(const DeviceClass& device_class, const std::string& text);

// The check_address of classes without an address.
Status check_no_address(std::string_view address);
// The `takes` of classes whose devices cannot be distinguished: one for a program.
std::vector<std::string> takes_the_only_one(std::string_view address, const DeviceDescription& description);

}  // namespace tactus::hal
