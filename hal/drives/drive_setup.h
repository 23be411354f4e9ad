// What is asked of the drives before an arm of them gets force: identity, ranges, mode, watchdog.
//
// Each drive is compared with the description. Its watchdog is set where the host can set it, else provoked and
// observed, else (CubeMars, mini-cheetah) taken from the description, which then must state it. No drive is left
// enabled and none gets a torque; a moteus and an ODrive are enabled without torque for some milliseconds to provoke
// their watchdog. Thread: [setup], or a normal thread with buses of its own. Bound: some requests per drive, each
// answered within kDriveAnswer or refused.
#pragma once

#include <string>

#include "hal/drives/drive_axis.h"
#include "hal/drives/drive_bus.h"
#include "rt/base/result.h"

namespace tactus::hal {

inline constexpr std::chrono::milliseconds kDriveAnswer{50};
inline constexpr double kLongestWatchdog_s = 0.01;

// Errors, one line each: which axis, what was found, what to do. The value: the drives as text, for the summary.
Result<std::string> prepare_drives(const DriveDescription& drives, const DriveBuses& buses);

// Reads what can be read again without disturbing the drives, and compares it. Error as above. A drive that restarted
// has lost what was written into its memory.
Status compare_drives(const DriveDescription& drives, const DriveBuses& buses);

}  // namespace tactus::hal
