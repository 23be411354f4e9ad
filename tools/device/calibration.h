// Signs and offsets of an arm of drives, from the drives' angles while a person holds the tool at known poses, without
// force.
//
// The pose with the tool at its centre gives the offset of each axis. For moves away from the centre the kinematics
// predict the axis changes d q; with the measured drive angles d theta:
//   sign = sign(sum(d theta d q)),  ratio = |sum(d theta d q)| / sum(d q^2),  sums over the moves
// The ratio is no more exact than the person's moves, so it is compared with the description's and not taken over.
// Thread: normal; pure. Units: rad of the drives' reported shafts, m. Frame: the device's.
#pragma once

#include <string>
#include <vector>

#include "hal/profiles.h"

namespace tactus::device {

// The tool was held there, and the drives reported these angles.
struct HeldPose {
  Posed device_from_tool;
  hal::AxisVector angle_rad{};
};

struct AxisCalibration {
  double sign{1}, offset_rad{0};
  double ratio_seen{0};
  std::string doubt;  // why the result is rejected; empty: accepted
};

// The poses to hold after the centre: along each axis of the frame, and for an arm with a wrist turned about each.
std::vector<Posed> calibration_poses(const hal::DeviceProfile& profile);
// "0.075 m along +x", "turned by 0.5 rad about +z".
std::string words_of(const Posed& pose);

// Precondition: the profile has drives.
std::vector<AxisCalibration> calibrate(const hal::DeviceProfile& profile, const hal::AxisVector& centre_rad,
                                       const std::vector<HeldPose>& moves);

// The largest share of a drive's position range that it turned to; beyond kUsableShare it may wrap. 0: no such range.
inline constexpr double kUsableShare = 0.9;
double range_share(const hal::DriveAxis& axis, double low_rad, double high_rad) noexcept;

// The text of a description with these signs and offsets; the other lines do not change.
std::string with_calibration(const std::string& text, const std::vector<AxisCalibration>& axes);

}  // namespace tactus::device
