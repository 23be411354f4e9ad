// Arms of drives for tests: a desktop point arm on three drives of each family, and a wristed arm on six moteus.
#pragma once

#include <catch2/catch.hpp>

#include "hal/drives/drive_check.h"
#include "hal/drives/simulated_drives.h"

namespace tactus::test {

inline constexpr std::int64_t kDrivePeriod_ns = 1'000'000;

// Figures of a DM3507 (ranges), of a small moteus, and the like; capstans of 2:1 so that signs and ratios matter.
inline hal::DriveAxis drive_axis(hal::DriveFamily family, unsigned number) {
  using hal::DriveFamily;
  constexpr double kPi = 3.14159265358979323846;
  hal::DriveAxis axis;
  axis.id = number + 1;
  axis.sign = number == 1 ? -1 : 1;
  axis.ratio = 2;
  axis.offset_rad = 0.1 * number - 0.2;
  axis.torque_range_Nm = 3;
  axis.damping_range_Nms_per_rad = 5;
  if (family == DriveFamily::kRobStride) {
    axis.position_range_rad = 4 * kPi;
    axis.speed_range_rad_per_s = 50;
  } else if (family == DriveFamily::kMoteus || family == DriveFamily::kOdrive) {
    axis.counts_per_turn = 16384;
  } else {
    axis.answer_id = 0x11 + number;
    axis.position_range_rad = 3.2;
    axis.speed_range_rad_per_s = 50;
  }
  if (family != DriveFamily::kOdrive) axis.brake_damping_Nms_per_rad = 0.02;
  return axis;
}

inline hal::DeviceProfile drive_profile(hal::DeviceDescription d) {
  hal::DeviceProfile profile = hal::make_profile(d);
  const hal::DriveMistake mistake = hal::find_drive_mistake(profile);
  INFO((mistake.key != nullptr ? mistake.key : "") << ": " << mistake.what);
  REQUIRE(mistake.key == nullptr);
  return profile;
}

inline void set_drive_quanta(hal::DeviceDescription& d) {
  const hal::AxisKinds kinds = hal::axes_of(d.kind);
  for (unsigned i = 0; i < kinds.prismatic + kinds.rotary; ++i)
    d.counts_per_turn[i] = hal::drive_counts_per_turn(d.drives.family, d.drives.axes[i]);
}

inline hal::DeviceDescription point_arm_of(hal::DriveFamily family, double damping_Nms_per_rad = 0) {
  hal::DeviceDescription d = hal::find_profile("desk3d")->description;
  d.name = "point arm of drives";
  d.drives.family = family;
  d.drives.buses = {"can0"};
  if (family == hal::DriveFamily::kMoteus) d.drives.data_bit_per_s = 5'000'000;
  for (unsigned i = 0; i < 3; ++i) {
    d.drives.axes.push_back(drive_axis(family, i));
    d.drives.axes.back().damping_Nms_per_rad = damping_Nms_per_rad;
  }
  set_drive_quanta(d);
  return d;
}

inline hal::DeviceDescription wristed_arm_of_moteus() {
  hal::DeviceDescription d = hal::find_profile("virtuose6d")->description;
  d.name = "wristed arm of moteus";
  d.drives.family = hal::DriveFamily::kMoteus;
  d.drives.buses = {"can0", "can1"};
  d.drives.data_bit_per_s = 5'000'000;
  for (unsigned i = 0; i < 6; ++i) {
    hal::DriveAxis axis = drive_axis(d.drives.family, i);
    axis.bus = i / 3;
    axis.ratio = i < 3 ? 8 : 2;
    axis.torque_range_Nm = 4;
    d.drives.axes.push_back(axis);
  }
  set_drive_quanta(d);
  return d;
}

inline std::unique_ptr<hal::SimulatedDriveArm> open_drives(const hal::DeviceDescription& d,
                                                           const hal::HandModel& hand = {}) {
  auto opened = hal::SimulatedDriveArm::open(drive_profile(d), hand, kDrivePeriod_ns);
  INFO(opened.message());
  REQUIRE(opened.ok());
  return std::move(opened).value();
}

}  // namespace tactus::test
