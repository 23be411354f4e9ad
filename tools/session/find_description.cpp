#include "tools/session/find_description.h"

#include <fmt/format.h>

#include "hal/device_file.h"

namespace tactus::session {

Result<hal::DeviceProfile> find_description(const std::string& profile_name, const std::filesystem::path& device_file) {
  if (!device_file.empty()) return hal::load_device_file(device_file);
  const hal::DeviceProfile* profile = hal::find_profile(profile_name);
  if (profile == nullptr)
    return Status::error(fmt::format("--profile: '{}' is none; accepted: virtuose6d, desk3d", profile_name));
  return *profile;
}

}  // namespace tactus::session
