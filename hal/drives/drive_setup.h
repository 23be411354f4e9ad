// Checks and prepares the drives of an arm before they may make torque: identity, ranges, mode, watchdog.
//
// Each drive is compared with the description. Its watchdog is set where the host can set it, else provoked and
// observed (of a moteus its configuration is read, too), else (CubeMars, mini-cheetah) taken from the description,
// which then must state it. No drive is left enabled and none gets a torque; a moteus and an ODrive are enabled without
// torque for some milliseconds to provoke their watchdog. Thread: [setup], or a normal thread with buses of its own.
// Bound: some requests per drive, each answered within kDriveAnswer or refused.
#pragma once

#include <string>
#include <vector>

#include "hal/drives/drive_axis.h"
#include "hal/drives/drive_bus.h"
#include "rt/base/result.h"

namespace tactus::hal {

inline constexpr std::chrono::milliseconds kDriveAnswer{50};
inline constexpr double kLongestWatchdog_s = 0.01;

// Errors, one line each: which axis, what was found, what to do. The value: each drive as text, with its serial number
// where the family has one (RobStride, moteus), for the summary and for compare_drives().
Result<std::vector<std::string>> prepare_drives(const DriveDescription& drives, const DriveBuses& buses);

// Reads everything that can be read without disturbing the drives, and compares it with the description, and the drives
// with `identities`. Error as above. A drive that restarted differs, because it has lost what was written into its
// memory.
Status compare_drives(const DriveDescription& drives, const DriveBuses& buses,
                      const std::vector<std::string>& identities);

}  // namespace tactus::hal
