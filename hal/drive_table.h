// Reads the tables [drives] and [[drives.axis]] of a device description: an arm of CAN drives
// (hal/drives/drive_axis.h). Thread: [setup]. Units: SI, in the key names.
#pragma once

#include "hal/device_description.h"
#include "rt/text/table_reader.h"

namespace tactus::hal {

// Fills in `device.drives` and the counts of the axes that follow from it. Mistakes go to the diagnostics.
void read_drives(const text::TomlNode* drives, DeviceDescription& device, text::Diagnostics& diagnostics);

// The first mistake of drives and kinematics together, at its key. Call when there is no other mistake.
void check_drives(const text::TomlNode* drives, const DeviceDescription& device, text::Diagnostics& diagnostics);

}  // namespace tactus::hal
