// The link that `--device` names, opened; and the description of the device that is expected on it.
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
  std::string name;  // for people: the port and the serial number, or the interface and the node
};

// `choice` is of a real device; what it leaves open the description says. One line on an error: what the machine lacks,
// and what to do.
Result<OpenedLink> open_link(const DeviceChoice& choice, const hal::DeviceDescription& description,
                             std::int64_t period_ns);

// The device file if one is named, else the built-in description of that name.
Result<hal::DeviceProfile> find_description(const std::string& profile_name, const std::filesystem::path& device_file);

}  // namespace tactus::session
