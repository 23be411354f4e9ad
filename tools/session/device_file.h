// Reading a device description from its TOML file, and saying everything that is wrong with it at once.
//
// Same quality of messages as for scenes: file, line, column, key, what was found, what is accepted; a mistake never
// hides the next one. Tables: [kinematics] [workspace] [limits] [mechanics] [encoders] [link]; the keys are those of
// hal/device_description.h and of the files in hal/devices/. Units: SI, in the key names. Thread: [setup].
// Bound: kMaxDeviceFileBytes; a longer file is refused by a mistake like any other.
#pragma once

#include <filesystem>
#include <string_view>

#include "hal/profiles.h"
#include "sim/loader/scene_load.h"

namespace tactus::session {

inline constexpr std::size_t kMaxDeviceFileBytes = 64u << 10;

// The description, or an error whose message lists every mistake, a line each. `name`: of the file, for the messages.
Result<hal::DeviceDescription> parse_device_description(std::string_view text, std::string_view name);

// What the program must know of the device that the file describes.
Result<hal::DeviceProfile> load_device_file(const std::filesystem::path& path);

}  // namespace tactus::session
