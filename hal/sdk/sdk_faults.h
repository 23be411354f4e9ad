// Faults that a maker's library reports, by number (hal/host_faults.h). dhd_port.cpp, hd_port.cpp and sdk_device.cpp
// raise them. Thread: the numbers [any]; describe_sdk_fault() allocates: normal threads.
#pragma once

#include <cstdint>
#include <string>

#include "hal/host_faults.h"

namespace tactus::hal {

inline constexpr std::uint32_t kSdkNotCalibrated = kOfHost | 96;  // the library has no reference for the arm's position
inline constexpr std::uint32_t kSdkMotorsWarm = kOfHost | 97;     // the motors' temperature
inline constexpr std::uint32_t kSdkForceTooLarge = kOfHost | 98;  // beyond what the library accepts
inline constexpr std::uint32_t kSdkForceTooSudden = kOfHost | 99;   // it rose faster than the library accepts
inline constexpr std::uint32_t kSdkTooFast = kOfHost | 100;         // the arm moved faster than the library accepts
inline constexpr std::uint32_t kSdkForceError = kOfHost | 101;      // another reason for which it gives no force
inline constexpr std::uint32_t kSdkDeviceFault = kOfHost | 102;     // the device itself
inline constexpr std::uint32_t kSdkConnectionLost = kOfHost | 103;  // between the library and the device
inline constexpr std::uint32_t kSdkLicenceRefused = kOfHost | 104;  // the maker's licence is not there or has ended
inline constexpr std::uint32_t kSdkTimeWentBack = kOfHost | 105;    // the library's clock
inline constexpr std::uint32_t kSdkForcesOff =
    kOfHost | 106;  // it switched the forces off, or refused them, and says no more

// What happened and what to do; empty for a number that is not one of these.
std::string describe_sdk_fault(std::uint32_t number);

}  // namespace tactus::hal
