// Texts for the faults and limits that a device reports by number (firmware/faults.h, host_faults.h), with what to do
// about them.
//
// Thread: normal. A number that this program does not know is printed as a number.
#pragma once

#include <cstdint>
#include <string>

#include "rt/base/status.h"
#include "rt/haptics/device.h"

namespace tactus::hal {

// "IDLE"; "state 9" for an unknown state.
std::string name_of(haptics::DeviceState state);

// "device fault 5: the motors' supply failed; restore it, then re-arm". Empty for 0.
std::string describe_device_fault(std::uint32_t number);

// The active limits from 72 to 79, by number and in words: those that suppress the force completely or do not reduce
// an effort. Empty if none is active. Bit n of `limits` is limit 64 + n.
std::string describe_device_limits(std::uint32_t limits);

// What the device reported in the tick in which a fault latched.
struct DeviceReport {
  haptics::DeviceState state{haptics::DeviceState::kReset};
  std::uint32_t fault{0}, limits{0};
};

// The complete line for a fault: what latched, and what the device reports about it.
std::string describe(Fault fault, const DeviceReport& device);

}  // namespace tactus::hal
