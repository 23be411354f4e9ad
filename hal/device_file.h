// Reads a device description from its TOML file and reports all its mistakes at once.
//
// Messages as for scenes: file, line, column, key, what was found, what is accepted. Reading continues after a mistake.
// Tables: [kinematics] [workspace] [limits] [mechanics] [plant] [encoders] or [drives] [link]; the keys are those of
// hal/device_description.h and of the files in hal/devices/. Units: SI, in the key names. Thread: [setup].
// Bound: kMaxDeviceFileBytes; a longer file is reported as a mistake.
#pragma once

#include <filesystem>
#include <string_view>

#include "hal/profiles.h"
#include "rt/base/result.h"

namespace tactus::hal {

inline constexpr std::size_t kMaxDeviceFileBytes = 64u << 10;

// Returns the description, or an error that lists every mistake, one per line. `name`: file name for the messages.
Result<DeviceDescription> parse_device_description(std::string_view text, std::string_view name);

// Returns the profile of the device described in the file.
Result<DeviceProfile> load_device_file(const std::filesystem::path& path);

}  // namespace tactus::hal
