#include "hal/drives/drive_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/can/can_interface.h"
#include "hal/drives/drive_codec.h"
#include "hal/drives/drive_setup.h"
#include "hal/kinematics/workspace_bounds.h"

namespace tactus::hal {
namespace {

constexpr double kPi = 3.14159265358979323846;
// A position nearer to the end of its field may wrap or stick, by the drive's firmware.
constexpr double kUsableRange = 0.9;

bool is_mit(DriveFamily family) noexcept {
  return family == DriveFamily::kDamiao || family == DriveFamily::kCubeMars || family == DriveFamily::kMiniCheetah;
}

DriveMistake of_buses(const DriveDescription& d) {
  if (d.buses.empty() || d.buses.size() > kMaxBuses)
    return {.axis = -1,
            .key = "buses",
            .what = fmt::format("{} buses", d.buses.size()),
            .accepted = fmt::format("1 to {}", kMaxBuses)};
  if (const Status status = check_bus_names(d.buses); !status.ok())
    return {.axis = -1,
            .key = "buses",
            .what = status.message(),
            .accepted = "the names of CAN interfaces, such as [\"can0\", \"can1\"]"};
  return {};
}

DriveMistake of_all(const DriveDescription& d, const DeviceDescription& device) {
  const AxisKinds kinds = axes_of(device.kind);
  const DriveCodec& codec = codec_of(d.family);
  if (d.axes.size() != kinds.prismatic + kinds.rotary)
    return {.axis = -1,
            .key = "axis",
            .what = fmt::format("{} entries", d.axes.size()),
            .accepted = fmt::format("{}, one for each axis in order", kinds.prismatic + kinds.rotary)};
  if (auto found = of_buses(d); found.key != nullptr) return found;
  if (codec.needs_fd && d.data_bit_per_s == 0)
    return {.axis = -1,
            .key = "data_bit_per_s",
            .what = fmt::format("missing, but {} needs CAN FD", codec.name),
            .accepted = "such as 5000000"};
  if (d.watchdog_s > kLongestWatchdog_s)
    return {.axis = -1,
            .key = "watchdog_ms",
            .what = fmt::format("{:g} ms: the drives hold a torque as long", 1e3 * d.watchdog_s),
            .accepted = "at most 10; set the drives to it"};
  return {};
}

DriveMistake of_identifiers(const DriveDescription& d, unsigned i) {
  const DriveAxis& axis = d.axes[i];
  const int at = static_cast<int>(i);
  const unsigned top = d.family == DriveFamily::kMoteus      ? 127
                       : d.family == DriveFamily::kOdrive    ? 63
                       : d.family == DriveFamily::kRobStride ? 127
                                                             : 0x7fe;
  if (axis.bus >= d.buses.size())
    return {.axis = at,
            .key = "bus",
            .what = fmt::format("{} is none of the buses", axis.bus),
            .accepted = "0 to the last"};
  if (axis.id < 1 || axis.id > top)
    return {
        .axis = at, .key = "id", .what = fmt::format("{} is no id", axis.id), .accepted = fmt::format("1 to {}", top)};
  if (is_mit(d.family) && axis.answer_id <= axis.id)
    return {.axis = at,
            .key = "answer_id",
            .what = fmt::format("{} would outrank the command of another drive", axis.answer_id),
            .accepted = "an identifier above those of all commands, another for each drive"};
  for (unsigned k = 0; k < d.axes.size(); ++k) {
    const DriveAxis& other = d.axes[k];
    if (other.bus != axis.bus || k == i) continue;
    if (other.id == axis.id)
      return {.axis = at,
              .key = "id",
              .what = fmt::format("{} is that of axis {}, too", axis.id, k),
              .accepted = "one of its own"};
    if (is_mit(d.family) && (other.answer_id == axis.answer_id || other.id >= axis.answer_id))
      return {.axis = at,
              .key = "answer_id",
              .what = fmt::format("{} meets axis {}", axis.answer_id, k),
              .accepted = "an identifier above those of all commands, another for each drive"};
  }
  return {};
}

DriveMistake of_gains(const DriveDescription& d, unsigned i) {
  const DriveAxis& axis = d.axes[i];
  const DriveCodec& codec = codec_of(d.family);
  const int at = static_cast<int>(i);
  if (std::abs(axis.sign) != 1)
    return {.axis = at, .key = "sign", .what = fmt::format("{:g}", axis.sign), .accepted = "1 or -1"};
  const auto damping = [&](const char* key, double value) -> DriveMistake {
    if (value <= 0) return {};
    if (!codec.damps)
      return {.axis = at,
              .key = key,
              .what = fmt::format("{} has no damping of its own", codec.name),
              .accepted = "leave it out"};
    if (value > axis.damping_range_Nms_per_rad)
      return {.axis = at,
              .key = key,
              .what = fmt::format("{:g} is beyond the drive's range", value),
              .accepted = fmt::format("at most {:g}", axis.damping_range_Nms_per_rad)};
    return {};
  };
  if (auto found = damping("damping_Nms_per_rad", axis.damping_Nms_per_rad); found.key != nullptr) return found;
  return d.family == DriveFamily::kMoteus ? DriveMistake{}
                                          : damping("brake_damping_Nms_per_rad", axis.brake_damping_Nms_per_rad);
}

// The largest distance of each drive's angle from its zero, over the workspace.
AxisVector farthest_angles(const DeviceProfile& profile) {
  const DriveDescription& d = profile.description.drives;
  AxisVector farthest{};
  for (unsigned k = 0; k <= detail::kDirections; ++k) {
    const Vec3d place =
        k < detail::kDirections ? detail::spread_direction(k) * profile.description.workspace_radius_m : Vec3d{};
    const AxisVector q = coordinates_of(profile.kinematics, {place, {}});
    for (unsigned i = 0; i < d.axes.size(); ++i) {
      const DriveAxis& axis = d.axes[i];
      // The wrist turns to its pitch limit, and half a turn about its other axes, wherever the tool is.
      const double wrist = i == kPitchAxis ? kPitchLimit_rad : kPi;
      const double angle = i < 3 ? std::abs(axis.offset_rad + axis.sign * axis.ratio * q[i])
                                 : std::abs(axis.offset_rad) + axis.ratio * wrist;
      farthest[i] = std::max(farthest[i], angle);
    }
  }
  return farthest;
}

DriveMistake of_ranges(const DeviceProfile& profile, unsigned i, double farthest_rad) {
  const DriveDescription& d = profile.description.drives;
  const DriveAxis& axis = d.axes[i];
  const int at = static_cast<int>(i);
  const double torque = profile.bounds.effort[i] / axis.ratio;
  if (torque > axis.torque_range_Nm)
    return {.axis = at,
            .key = "torque_range_Nm",
            .what = fmt::format("{:g}, but the peak force and torque at the tool need {:.3g} of the drive",
                                axis.torque_range_Nm, torque),
            .accepted = "a stronger drive, a larger ratio, or lower limits"};
  if (axis.position_range_rad > 0 && farthest_rad > kUsableRange * axis.position_range_rad)
    return {.axis = at,
            .key = "position_range_rad",
            .what = fmt::format("{:g}, but the drive turns to {:.3g} in the workspace", axis.position_range_rad,
                                farthest_rad),
            .accepted = "at most nine tenths of it are used: another offset, a smaller ratio, or a wider range"};
  return {};
}

}  // namespace

Status check_bus_names(const std::vector<std::string>& names) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (Status status = check_can_name(names[i]); !status.ok()) return status;
    for (std::size_t k = 0; k < i; ++k)
      if (names[k] == names[i]) return Status::error(fmt::format("names {} twice, which is one bus", names[i]));
  }
  return Status::good();
}

Status check_watchdog(const DriveDescription& drives, std::chrono::nanoseconds period) {
  const double period_s = static_cast<double>(period.count()) * 1e-9, least_s = kLeastWatchdogPeriods * period_s;
  if (drives.watchdog_s >= least_s * (1 - 1e-9)) return Status::good();
  const double least_Hz = std::ceil(kLeastWatchdogPeriods / drives.watchdog_s * (1 - 1e-9));
  const std::string longer = least_s <= kLongestWatchdog_s ? fmt::format("watchdog_ms = {:g} to {:g}, or ",
                                                                         1e3 * least_s, 1e3 * kLongestWatchdog_s)
                                                           : std::string();
  return Status::error(fmt::format(
      "watchdog_ms is {:g}, {:.3g} of the periods of {:.4g} ms: it would end the force for a command that is late; "
      "accepted: at least {} periods, that is {}--rate {:.0f} at least",
      1e3 * drives.watchdog_s, drives.watchdog_s / period_s, 1e3 * period_s, kLeastWatchdogPeriods, longer, least_Hz));
}

DriveMistake find_drive_mistake(const DeviceProfile& profile) {
  const DriveDescription& d = profile.description.drives;
  if (auto found = of_all(d, profile.description); found.key != nullptr) return found;
  const AxisVector farthest = farthest_angles(profile);
  for (unsigned i = 0; i < d.axes.size(); ++i) {
    if (auto found = of_identifiers(d, i); found.key != nullptr) return found;
    if (auto found = of_gains(d, i); found.key != nullptr) return found;
    if (auto found = of_ranges(profile, i, farthest[i]); found.key != nullptr) return found;
  }
  return {};
}

}  // namespace tactus::hal
