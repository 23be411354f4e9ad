#include "hal/drives/drive_damping.h"

#include <algorithm>
#include <array>

#include "hal/drives/drive_codec.h"
#include "hal/kinematics/workspace_bounds.h"

namespace tactus::hal {
namespace {

// The least eigenvalue of the Gram matrix of these columns: trace bound minus the largest eigenvalue of (trace I - G),
// by power iteration from a start that is no eigenvector by coincidence.
double least_eigenvalue(const std::array<Vec3d, kAxisCount>& rows) noexcept {
  double trace = 0;
  for (const Vec3d& row : rows) trace += norm_squared(row);
  if (trace <= 0) return 0;
  Vec3d direction = normalized_or(Vec3d{0.9, 0.7, 0.5}, Vec3d{1, 0, 0});
  double largest = 0;
  for (int i = 0; i < 300; ++i) {
    Vec3d image = direction * trace;
    for (const Vec3d& row : rows) image -= row * dot(row, direction);
    largest = norm(image);
    direction = normalized_or(image, direction);
  }
  return std::max(0.0, trace - largest);
}

// sqrt(d_i) times the axis's row of J^-1, for translation without rotation or the reverse.
template <bool kLinear>
double least_at(const Kinematics& kinematics, const AxisVector& q, const AxisVector& damping) noexcept {
  std::array<Vec3d, kAxisCount> rows{};
  const std::array<Vec3d, 3> units{Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}};
  for (const Vec3d& unit : units) {
    const AxisVector rate = kinematics.rates_of(q, kLinear ? Twistd{unit, {}} : Twistd{{}, unit});
    for (unsigned axis = 0; axis < kAxisCount; ++axis) rows[axis] += unit * (std::sqrt(damping[axis]) * rate[axis]);
  }
  return least_eigenvalue(rows);
}

}  // namespace

AxisVector axis_damping(const DriveDescription& drives) noexcept {
  AxisVector damping{};
  for (unsigned i = 0; i < drives.axes.size() && i < kAxisCount; ++i) {
    const DriveAxis& axis = drives.axes[i];
    // The damping that a frame's field can represent: a whole number of steps, which may be less than is described.
    const double sent = sent_damping_Nms_per_rad(drives.family, axis, axis.damping_Nms_per_rad);
    damping[i] = sent * axis.ratio * axis.ratio;
  }
  return damping;
}

ToolDamping least_tool_damping(const Kinematics& kinematics, const AxisVector& damping, double workspace_radius_m,
                               bool has_rotation) noexcept {
  ToolDamping least{1e300, 1e300};
  for (unsigned k = 0; k <= detail::kDirections; ++k) {
    const Vec3d place = k < detail::kDirections ? detail::spread_direction(k) * workspace_radius_m : Vec3d{};
    AxisVector q = coordinates_of(kinematics, {place, {}});
    q[3] = q[4] = q[5] = 0;
    least.translation_Ns_per_m = std::min(least.translation_Ns_per_m, least_at<true>(kinematics, q, damping));
    if (!has_rotation) continue;
    for (const double pitch : {-kPitchLimit_rad, 0.0, kPitchLimit_rad}) {
      q[kPitchAxis] = pitch;
      least.rotation_Nms_per_rad = std::min(least.rotation_Nms_per_rad, least_at<false>(kinematics, q, damping));
    }
  }
  least.translation_Ns_per_m /= kSpreadMargin;
  least.rotation_Nms_per_rad = has_rotation ? least.rotation_Nms_per_rad / kSpreadMargin : 0;
  return least;
}

}  // namespace tactus::hal
