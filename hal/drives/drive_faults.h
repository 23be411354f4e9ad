// Faults that an arm of drives reports, by number (hal/host_faults.h).
//
// Those of kDriveReportsFault and kDriveLeftForce contain what the drive reported. Bits 0 to 7: the number; bits 8 to
// 11: the family plus one; bits 12 to 30: the family's code, or the mode; for a family with error bits, the position of
// the lowest set bit plus one. An axis is 0 to 5, in the order of the description.
// Thread: the numbers, drive_left_force(), drive_never_enabled(), drive_fault_of(), number_of_drive_fault() [any],
// [rt], pure; the describe functions allocate: normal threads. Source of the codes' words: the makers' manuals.
#pragma once

#include <cstdint>
#include <string>

#include "hal/drives/drive_codec.h"
#include "hal/host_faults.h"

namespace tactus::hal {

inline constexpr std::uint32_t kDriveReportsFault = kOfHost | 32;  // + axis, 0 to 5: the drive reports a fault
inline constexpr std::uint32_t kDriveLeftForce = kOfHost | 40;     // + axis: it is not enabled any more, or was never
inline constexpr std::uint32_t kDriveSilent = kOfHost | 48;        // + axis: no answer for ten periods
inline constexpr std::uint32_t kDriveLacksTorque = kOfHost | 56;   // + axis: it answers, but makes no torque

// Both return kDriveLeftForce + axis: with the mode that the drive reports; for a drive that was not enabled in time.
std::uint32_t drive_left_force(unsigned axis, DriveFamily family, DriveMode told) noexcept;
std::uint32_t drive_never_enabled(unsigned axis, DriveFamily family) noexcept;
// kDriveReportsFault + axis, with the code of the drive.
std::uint32_t drive_fault_of(unsigned axis, DriveFamily family, std::uint32_t code) noexcept;
// One of the four above, plus axis, without the family and the code.
constexpr std::uint32_t number_of_drive_fault(std::uint32_t fault) noexcept { return fault & (kOfHost | 0xffu); }

// "status 10, over-current", "error bits 0x800, its watchdog": the drive's own code, in words where they are known.
std::string describe_drive_code(DriveFamily family, std::uint32_t code);

// What happened and what to do; empty for a number that is not one of these.
std::string describe_drive_fault(std::uint32_t fault);

}  // namespace tactus::hal
