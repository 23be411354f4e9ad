// Checks the description of an arm of drives for consistency: axes, identifiers, ranges, watchdog.
// Thread: [setup]. Only check_watchdog and check_bus_load depend on the rate.
#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "hal/profiles.h"
#include "rt/base/result.h"

namespace tactus::hal {

// The first mistake, by its key in a file; `axis`: of which [[drives.axis]], -1: of [drives].
struct DriveMistake {
  int axis{-1};
  const char* key{nullptr};  // null: no mistake
  std::string what, accepted;
};

DriveMistake find_drive_mistake(const DeviceProfile& profile);

// Are these CAN interfaces, none of them twice? One bus under two names of the list would carry twice its load, and two
// drives with one identifier. Error: without the option or key.
Status check_bus_names(const std::vector<std::string>& names);

// The drives' watchdogs must outlast some lost or late commands: this many periods.
inline constexpr int kLeastWatchdogPeriods = 5;
// Error, one line: the watchdog in periods, and what is accepted.
Status check_watchdog(const DriveDescription& drives, std::chrono::nanoseconds period);

}  // namespace tactus::hal
