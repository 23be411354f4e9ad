// What a device says of itself, in words: its faults and limits by number (firmware/faults.h), and what to do.
//
// Thread: normal. A number that this program does not know is told as a number.
#pragma once

#include <cstdint>
#include <string>

#include "rt/base/status.h"
#include "rt/haptics/device.h"

namespace tactus::hal {

// "IDLE"; "state 9" for one that is none.
std::string name_of(haptics::DeviceState state);

// "device fault 5: the motors' supply failed; restore it, then re-arm". Empty for 0.
std::string describe_device_fault(std::uint32_t number);

// Of the limits that hold force back altogether or are no cut of an effort (72 to 79), by number and in words; empty if
// none is active. Bit n is limit 64 + n.
std::string describe_device_limits(std::uint32_t limits);

// What the device said in the tick in which a fault latched.
struct DeviceReport {
  haptics::DeviceState state{haptics::DeviceState::kReset};
  std::uint32_t fault{0}, limits{0};
};

// The whole line of a fault: what latched, and what the device itself says of it.
std::string describe(Fault fault, const DeviceReport& device);

}  // namespace tactus::hal
