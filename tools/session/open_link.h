// Opens the link that `--device` names and finds the description of the device expected on it.
//
// Thread: normal, before the loop runs.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "hal/any_link.h"
#include "hal/profiles.h"
#include "tools/session/device_choice.h"

namespace tactus::session {

struct OpenedLink {
  std::unique_ptr<hal::AnyLink> link;
  std::string name;  // readable: port and serial number, or interface and node
};

// `choice` must name a real device; the description fills in what it leaves open. Error, one line: what the machine
// lacks, and the remedy.
Result<OpenedLink> open_link(const DeviceChoice& choice, const hal::DeviceDescription& description,
                             std::int64_t period_ns);

// Returns the profile of the device file if one is named, otherwise the built-in description of that name.
Result<hal::DeviceProfile> find_description(const std::string& profile_name, const std::filesystem::path& device_file);

}  // namespace tactus::session
