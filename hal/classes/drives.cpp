// drives[:IFACE[,IFACE]]: an arm of CAN drives that the description describes, on SocketCAN; drives-sim: the same arm
// on simulated drives in the haptic thread.
#include <fmt/format.h>

#include "hal/device_class.h"
#include "hal/drives/bus_load.h"
#include "hal/drives/drive_check.h"
#include "hal/drives/drive_setup.h"
#include "hal/drives/drive_socket.h"
#include "hal/drives/simulated_drives.h"
#include "rt/text/split.h"

namespace tactus::hal {
namespace {

std::vector<std::string> interfaces_of(std::string_view address) {
  return address.empty() ? std::vector<std::string>{} : text::split(address, ',');
}

Status check_address(std::string_view address) {
  const std::vector<std::string> names = interfaces_of(address);
  if (names.size() > kMaxBuses) return Status::error(fmt::format("names more than {} interfaces", kMaxBuses));
  return check_bus_names(names);
}

Status check_drives(const DeviceRequest& request) {
  const DriveDescription& drives = request.profile.description.drives;
  if (drives.empty())
    return Status::error(
        fmt::format("the description of {} has no drives; accepted: a --device-file with [drives], "
                    "such as hal/devices/point_arm_drives.toml",
                    request.profile.name));
  const std::chrono::nanoseconds period(request.period_ns);
  if (Status status = check_watchdog(drives, period); !status.ok()) return status;
  return check_bus_load(drives, period);
}

std::vector<std::string> takes(std::string_view address, const DeviceDescription& description) {
  return address.empty() ? description.drives.buses : interfaces_of(address);
}

std::string watchdog_of(const DriveDescription& drives) {
  switch (drives.family) {
    case DriveFamily::kDamiao:
    case DriveFamily::kRobStride:
      return fmt::format("the drives' own, {:g} ms, were written and read back, nothing provokes them",
                         1e3 * drives.watchdog_s);
    case DriveFamily::kMoteus:
    case DriveFamily::kOdrive:
      return "the drives' own were provoked when the arm was opened";
    default:
      return "the drives' own can neither be read nor provoked: set them with the maker's tool";
  }
}

std::vector<NotChecked> not_checked_of(const DriveDescription& drives) {
  return {{"round-trip", "no drive echoes a number: an answer counts as one to the newest command"},
          {"watchdog", "what brakes here is this program; " + watchdog_of(drives)}};
}

Result<OpenedDevice> open(const DeviceRequest& request) {
  if (Status status = check_drives(request); !status.ok()) return status;
  const DriveDescription& drives = request.profile.description.drives;
  const std::vector<std::string> interfaces = request.address.empty() ? drives.buses : interfaces_of(request.address);
  if (interfaces.size() != drives.buses.size())
    return Status::error(
        fmt::format("{} interfaces for the description's {} buses", interfaces.size(), drives.buses.size()));
  auto buses = open_drive_sockets(drives, interfaces);
  if (!buses.ok()) return buses.status();
  auto prepared = prepare_drives(drives, buses.value());
  if (!prepared.ok()) return prepared.status();
  auto arm = std::make_unique<DriveArm>(request.profile, request.period_ns, std::move(buses).value());
  // Sockets of its own: the haptic thread has the others.
  const std::vector<std::string> identities = std::move(prepared).value();
  auto same_device = [drives, interfaces, identities] {
    auto opened = open_drive_sockets(drives, interfaces);
    return opened.ok() ? compare_drives(drives, opened.value(), identities) : opened.status();
  };
  return OpenedDevice{.device = std::make_unique<AnyDevice>(std::move(arm)),
                      .identity = fmt::format("{}", fmt::join(identities, ", ")),
                      .same_device = same_device,
                      .not_checked = not_checked_of(drives)};
}

// The faults of a script that a bus of drives can have, on all drives at once.
Result<std::vector<DriveFault>> drive_faults_of(const FaultScript& script) {
  std::vector<DriveFault> faults;
  for (unsigned i = 0; i < script.count; ++i) {
    const InjectedFault& fault = script.faults[i];
    const bool of_answers = fault.direction != FaultDirection::kCommand;
    DriveFault made{.axis = kAllAxes, .tick = fault.tick, .ticks = fault.ticks};
    if (fault.kind == FaultKind::kLost)
      made.kind = of_answers ? DriveFaultKind::kNoAnswer : DriveFaultKind::kNoCommand;
    else if (fault.kind == FaultKind::kLate && of_answers)
      made.kind = DriveFaultKind::kLate;
    else if (fault.kind == FaultKind::kDuplicated && of_answers)
      made.kind = DriveFaultKind::kTwice;
    else if (fault.kind == FaultKind::kCorrupted && of_answers)
      made.kind = DriveFaultKind::kShort;
    else if (fault.kind == FaultKind::kUnplugged)
      made.kind = DriveFaultKind::kBusOff;
    else if (fault.kind == FaultKind::kFrozen)
      made.kind = DriveFaultKind::kRestarted;
    else
      return Status::error(
          "--inject: drives-sim has lost, late, duplicated and corrupted of the state, lost/command, "
          "unplugged, and frozen, which restarts the drives");
    faults.push_back(made);
  }
  if (faults.size() >= SimulatedDrives::kMaxFaults)
    return Status::error(fmt::format("--inject: drives-sim takes fewer than {} faults", SimulatedDrives::kMaxFaults));
  return faults;
}

Result<OpenedDevice> open_simulated(const DeviceRequest& request) {
  if (Status status = check_drives(request); !status.ok()) return status;
  const auto faults = drive_faults_of(request.faults);
  if (!faults.ok()) return faults.status();
  auto arm = SimulatedDriveArm::open(request.profile, request.hand, request.period_ns);
  if (!arm.ok()) return arm.status();
  for (const DriveFault& fault : faults.value()) arm.value()->world().inject(fault);
  std::string identity = "simulated: " + arm.value()->identity();
  return OpenedDevice{.device = std::make_unique<AnyDevice>(std::move(arm).value()),
                      .identity = std::move(identity),
                      .same_device = {},
                      .not_checked = not_checked_of(request.profile.description.drives)};
}

}  // namespace

extern const DeviceClass drives_class, simulated_drives_class;

const DeviceClass drives_class{.name = "drives",
                               .forms = "drives, drives:IFACE, drives:IFACE,IFACE",
                               .what = "an arm of CAN drives, whose description has [drives]",
                               .real = true,
                               .check_address = check_address,
                               .open = open,
                               .takes = takes,
                               .each_its_own = "such as drives:can0 and drives:can1, or drives-sim",
                               .can_interfaces = interfaces_of};

const DeviceClass simulated_drives_class{.name = "drives-sim",
                                         .forms = "drives-sim",
                                         .what = "an arm of simulated CAN drives",
                                         .check_address = check_no_address,
                                         .open = open_simulated,
                                         .hand_by_script = true};

}  // namespace tactus::hal
