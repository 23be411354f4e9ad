// Checks that no two hands use the same device: the same interface, serial number, or only device of a library. Reads
// names and descriptions and accesses no hardware. Thread: normal.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "rt/base/result.h"

namespace tactus::session {

struct NamedDevice {
  std::string device;  // as --device
  std::filesystem::path file;
};

// By hand. `profile_name`: of those without a file. Error, one line: which device, of which hand, and what is accepted.
// A device or a file that is not valid is reported where it is read, not here.
Status check_distinct(std::span<const NamedDevice> devices, const std::string& profile_name);

}  // namespace tactus::session
