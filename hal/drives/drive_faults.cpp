#include "hal/drives/drive_faults.h"

#include <fmt/format.h>

#include "hal/kinematics/tool_kinematics.h"

namespace tactus::hal {

std::string describe_drive_fault(std::uint32_t number) {
  const auto in = [number](std::uint32_t first) { return number >= first && number < first + kAxisCount; };
  if (in(kDriveReportsFault))
    return fmt::format("the drive of axis {} reports a fault; look it up with the maker's tool, mend it, then re-arm",
                       number - kDriveReportsFault);
  if (in(kDriveLeftForce))
    return fmt::format(
        "the drive of axis {} is not enabled any more: its watchdog, its supply or another program; "
        "look at supply and bus, then re-arm",
        number - kDriveLeftForce);
  if (in(kDriveSilent))
    return fmt::format("the drive of axis {} does not answer; look at its cable and supply, then re-arm",
                       number - kDriveSilent);
  return {};
}

}  // namespace tactus::hal
