// Faults that a maker's library reports, by number; firmware/faults.h and drives/drive_faults.h have those below 80.
// Never reused.
#pragma once

#include <cstdint>
#include <string>

namespace tactus::hal {

inline constexpr std::uint32_t kSdkNotCalibrated = 96;    // the library does not know where the arm is
inline constexpr std::uint32_t kSdkMotorsWarm = 97;       // the motors' temperature
inline constexpr std::uint32_t kSdkForceTooLarge = 98;    // beyond what the library accepts
inline constexpr std::uint32_t kSdkForceTooSudden = 99;   // it rose faster than the library accepts
inline constexpr std::uint32_t kSdkTooFast = 100;         // the arm moved faster than the library accepts
inline constexpr std::uint32_t kSdkForceError = 101;      // another reason for which it gives no force
inline constexpr std::uint32_t kSdkDeviceFault = 102;     // the device itself
inline constexpr std::uint32_t kSdkConnectionLost = 103;  // between the library and the device
inline constexpr std::uint32_t kSdkLicenceRefused = 104;  // the maker's licence is not there or has ended
inline constexpr std::uint32_t kSdkTimeWentBack = 105;    // the library's clock

// What happened and what to do; empty for a number that is not one of these.
std::string describe_sdk_fault(std::uint32_t number);

}  // namespace tactus::hal
