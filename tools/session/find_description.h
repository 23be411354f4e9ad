// Finds the description of the device that a run expects. Thread: normal, before the loop runs.
#pragma once

#include <filesystem>
#include <string>

#include "hal/profiles.h"
#include "rt/base/result.h"

namespace tactus::session {

// Returns the profile of the device file if one is named, otherwise the built-in description of that name.
Result<hal::DeviceProfile> find_description(const std::string& profile_name, const std::filesystem::path& device_file);

}  // namespace tactus::session
