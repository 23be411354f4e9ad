// Faults that an arm of drives reports, by number; firmware/faults.h has the numbers below 32. Never reused.
#pragma once

#include <cstdint>
#include <string>

namespace tactus::hal {

inline constexpr std::uint32_t kDriveReportsFault = 32;  // + axis, 0 to 5: the drive reports a fault
inline constexpr std::uint32_t kDriveLeftForce = 40;     // + axis: it is not enabled any more
inline constexpr std::uint32_t kDriveSilent = 48;        // + axis: no answer for ten periods

// What happened and what to do; empty for a number that is not one of these.
std::string describe_drive_fault(std::uint32_t number);

}  // namespace tactus::hal
