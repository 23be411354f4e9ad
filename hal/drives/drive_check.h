// Does the description of an arm of drives go together: axes, identifiers, ranges, watchdog?
// Thread: [setup]. The load of the buses depends on the rate: check_bus_load.
#pragma once

#include "hal/profiles.h"

namespace tactus::hal {

// The first mistake, by its key in a file; `axis`: of which [[drives.axis]], -1: of [drives].
struct DriveMistake {
  int axis{-1};
  const char* key{nullptr};  // null: no mistake
  std::string what, accepted;
};

DriveMistake find_drive_mistake(const DeviceProfile& profile);

}  // namespace tactus::hal
