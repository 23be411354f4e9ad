#include "tools/device/calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/kinematics/workspace_bounds.h"
#include "rt/base/rotation_vector.h"

namespace tactus::device {
namespace {

constexpr double kTurned_rad = 0.5;
// An axis with sqrt(sum(d q^2)) below this is not judged.
constexpr double kLeastTurn_rad = 0.05;
// A person places the tool to some centimetres: a ratio that is further off is wrong in the description.
constexpr double kRatioDoubt = 0.35;

Vec3d unit(unsigned axis) noexcept { return {axis == 0 ? 1.0 : 0.0, axis == 1 ? 1.0 : 0.0, axis == 2 ? 1.0 : 0.0}; }

// Angles are not wrapped: drive angles that differ by whole turns are one position of the motor, but not of the axis.
AxisCalibration of_axis(const hal::DriveAxis& axis, unsigned i, const hal::AxisVector& centre_q,
                        const hal::AxisVector& centre_rad, const std::vector<HeldPose>& moves,
                        const hal::Kinematics& kinematics) {
  double turned = 0, squares = 0;
  for (const HeldPose& move : moves) {
    const double dq = hal::coordinates_of(kinematics, move.device_from_tool)[i] - centre_q[i];
    turned += (move.angle_rad[i] - centre_rad[i]) * dq;
    squares += dq * dq;
  }
  AxisCalibration found;
  found.sign = turned < 0 ? -1 : 1;
  found.ratio_seen = squares > 0 ? std::abs(turned) / squares : 0;
  found.offset_rad = centre_rad[i] - found.sign * axis.ratio * centre_q[i];
  if (std::sqrt(squares) < kLeastTurn_rad)
    found.doubt = "the moves do not turn it; its sign is not known";
  else if (std::abs(found.ratio_seen - axis.ratio) > kRatioDoubt * axis.ratio)
    found.doubt = fmt::format(
        "it turned {:.3g} rad per rad of its axis, the description's ratio is {:g}: another drive, "
        "another ratio, or the tool was elsewhere",
        found.ratio_seen, axis.ratio);
  return found;
}

bool sets(const std::string& line, const std::string& key) {
  const std::size_t first = line.find_first_not_of(" \t");
  if (first == std::string::npos || line.compare(first, key.size(), key) != 0) return false;
  const std::size_t next = line.find_first_not_of(" \t", first + key.size());
  return next != std::string::npos && line[next] == '=';
}

}  // namespace

std::vector<Posed> calibration_poses(const hal::DeviceProfile& profile) {
  std::vector<Posed> poses;
  const double distance_m = 0.5 * profile.description.workspace_radius_m;
  for (unsigned axis = 0; axis < 3; ++axis) poses.push_back({unit(axis) * distance_m, {}});
  if (profile.description.has_rotation())
    for (unsigned axis = 0; axis < 3; ++axis)
      poses.push_back({{}, quat_from_rotation_vector(unit(axis) * kTurned_rad)});
  return poses;
}

std::string words_of(const Posed& pose) {
  const Vec3d turn = rotation_vector_of(pose.rotation);
  const bool moved = norm(pose.position) > 0;
  const Vec3d along = moved ? pose.position : turn;
  const char axis = along.x > 0 ? 'x' : along.y > 0 ? 'y' : 'z';
  if (norm(along) == 0) return "at the centre of its workspace, not turned";
  return moved ? fmt::format("{:g} m from the centre along +{}, not turned", norm(along), axis)
               : fmt::format("at the centre, turned by {:.0f} degrees about +{}", norm(along) * 360 / hal::kTurn_rad,
                             axis);
}

std::vector<AxisCalibration> calibrate(const hal::DeviceProfile& profile, const hal::AxisVector& centre_rad,
                                       const std::vector<HeldPose>& moves) {
  const auto& axes = profile.description.drives.axes;
  const hal::AxisVector centre_q = hal::coordinates_of(profile.kinematics, {});
  std::vector<AxisCalibration> found;
  for (unsigned i = 0; i < axes.size(); ++i)
    found.push_back(of_axis(axes[i], i, centre_q, centre_rad, moves, profile.kinematics));
  return found;
}

double range_share(const hal::DriveAxis& axis, double low_rad, double high_rad) noexcept {
  if (axis.position_range_rad <= 0) return 0;
  return std::max(std::abs(low_rad), std::abs(high_rad)) / axis.position_range_rad;
}

std::string with_calibration(const std::string& text, const std::vector<AxisCalibration>& axes) {
  std::string result;
  std::size_t axis = axes.size();
  std::size_t next = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    at = end + 1;
    const std::size_t first = line.find_first_not_of(" \t");
    const bool is_table = first != std::string::npos && line[first] == '[';
    std::string table = is_table ? line.substr(first, line.find(']', first) - first) : "";
    std::erase_if(table, [](char c) { return c == ' ' || c == '\t'; });
    const bool is_axis = table == "[[drives.axis";
    if (is_table) axis = is_axis && next < axes.size() ? next++ : axes.size();
    if (axis < axes.size() && (sets(line, "sign") || sets(line, "offset_rad"))) continue;  // written above
    result += line + "\n";
    if (is_axis && axis < axes.size())
      result += fmt::format("sign = {:g}\noffset_rad = {:.6g}  # tactus device calibrate\n", axes[axis].sign,
                            axes[axis].offset_rad);
  }
  return result;
}

}  // namespace tactus::device
