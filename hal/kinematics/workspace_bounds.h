// Bounds over a device's whole workspace: quanta, axis efforts and axis rates, from sampled poses, once, at set-up.
//
// Works for any ToolKinematics whose tool moves freely inside a sphere about the device frame's origin, the wrist
// within its pitch limit. A bound is the worst of the sampled poses times kSpreadMargin for the poses between them (the
// property test tries 20 000 others). Frame: the device's. Units: SI. Thread: [setup]; no allocation; about ten
// thousand evaluations of the kinematics, milliseconds. Same bits in every build.
#pragma once

#include <algorithm>

#include "hal/hand.h"
#include "hal/kinematics/wrist.h"

namespace tactus::hal {

inline constexpr double kSpreadMargin = 1.08;

// Axis coordinates of a pose, by Newton iteration with bounded steps from the rest pose. The pitch is clamped to its
// limit; rotations that the device cannot make are ignored.
template <ToolKinematics K>
AxisVector coordinates_of(const K& kinematics, const Posed& device_from_tool) noexcept {
  constexpr int kMaxSteps = 200;
  constexpr double kLongestStep_m = 0.05, kLongestTurn_rad = 0.2, kClose = 1e-14;  // m and rad
  AxisVector q{};
  for (int i = 0; i < kMaxSteps; ++i) {
    const Posed here = kinematics.pose_of(q);
    Twistd way{device_from_tool.position - here.position,
               rotation_vector_of(device_from_tool.rotation * conjugate(here.rotation))};
    const double distance = norm(way.linear), angle = norm(way.angular);
    if (distance < kClose && angle < kClose) break;
    if (distance > kLongestStep_m) way.linear = way.linear * (kLongestStep_m / distance);
    if (angle > kLongestTurn_rad) way.angular = way.angular * (kLongestTurn_rad / angle);
    const AxisVector rate = kinematics.rates_of(q, way);
    for (unsigned axis = 0; axis < kAxisCount; ++axis) q[axis] += rate[axis];
    q[kPitchAxis] = std::clamp(q[kPitchAxis], -kPitchLimit_rad, kPitchLimit_rad);
  }
  return q;
}

// Limits of the tool.
struct ToolLimits {
  double workspace_radius_m{0};
  double force_N{0}, torque_Nm{0};
  double speed_m_per_s{0}, angular_speed_rad_per_s{0};
};

struct WorkspaceBounds {
  // Resolution of the tool's pose: known to within half of these along each axis of the device's frame.
  double position_quantum_m{0}, rotation_quantum_rad{0};
  AxisVector effort{};        // N or N m: largest axis effort for any wrench within the limits
  double arm_effort_norm{0};  // N or N m: largest norm of the efforts of axes 0 to 2
  AxisVector rate{};          // m/s or rad/s: largest axis rate for any twist within the limits, wrist at zero
};

namespace detail {

inline constexpr unsigned kDirections = 60, kWristYaws = 6;

// Directions spread evenly over the sphere: a spiral in steps of the golden angle.
inline Vec3d spread_direction(unsigned k) noexcept {
  constexpr double kGoldenAngle_rad = 2.39996322972865332;
  const double z = 1.0 - (2.0 * k + 1.0) / kDirections, across = std::sqrt(1.0 - z * z);
  const auto turn = sin_cos(kGoldenAngle_rad * k);
  return {across * turn.cos, across * turn.sin, z};
}

// The largest singular value of the matrix with these columns: the root of the largest eigenvalue of its Gram matrix,
// by power iteration. The start vector is chosen so that it is not an eigenvector by coincidence.
inline double largest_stretch(const std::array<Vec3d, 3>& columns) noexcept {
  Vec3d direction = normalized_or(Vec3d{0.9, 0.7, 0.5}, Vec3d{1, 0, 0});
  double stretch = 0;
  for (int i = 0; i < 60; ++i) {
    Vec3d image;
    for (const Vec3d& column : columns) image += column * dot(column, direction);
    stretch = std::sqrt(norm(image));
    direction = normalized_or(image, direction);
  }
  return stretch;
}

template <ToolKinematics K>
void widen_quanta(const K& kinematics, const AxisVector& q, const AxisVector& quantum,
                  WorkspaceBounds& bounds) noexcept {
  Vec3d off_m, off_rad;
  for (unsigned axis = 0; axis < kAxisCount; ++axis) {
    const Twistd column = kinematics.twist_of(q, unit_axis(axis));
    off_m += abs(column.linear) * quantum[axis];
    off_rad += abs(column.angular) * quantum[axis];
  }
  bounds.position_quantum_m = std::max({bounds.position_quantum_m, off_m.x, off_m.y, off_m.z});
  bounds.rotation_quantum_rad = std::max({bounds.rotation_quantum_rad, off_rad.x, off_rad.y, off_rad.z});
}

template <ToolKinematics K>
void widen_drives(const K& kinematics, const AxisVector& q, const ToolLimits& limits,
                  WorkspaceBounds& bounds) noexcept {
  std::array<Vec3d, 3> linear, angular;
  for (unsigned axis = 0; axis < kAxisCount; ++axis) {
    const Twistd column = kinematics.twist_of(q, unit_axis(axis));
    const double effort = limits.force_N * norm(column.linear) + limits.torque_Nm * norm(column.angular);
    bounds.effort[axis] = std::max(bounds.effort[axis], effort);
    if (axis < 3) {
      linear[axis] = column.linear;
      angular[axis] = column.angular;
    }
    // The wrench of a unit effort on one axis is that axis's row of the inverse Jacobian.
    const Wrenchd row = kinematics.wrench_of(q, unit_axis(axis));
    const double rate = limits.speed_m_per_s * norm(row.force) + limits.angular_speed_rad_per_s * norm(row.torque);
    bounds.rate[axis] = std::max(bounds.rate[axis], rate);
  }
  const double together = limits.force_N * largest_stretch(linear) + limits.torque_Nm * largest_stretch(angular);
  bounds.arm_effort_norm = std::max(bounds.arm_effort_norm, together);
}

}  // namespace detail

template <ToolKinematics K>
WorkspaceBounds bounds_over(const K& kinematics, const AxisVector& quantum, const ToolLimits& limits) noexcept {
  constexpr double kHalfTurn_rad = 3.14159265358979323846;  // the other half is its mirror image
  WorkspaceBounds bounds;
  for (unsigned k = 0; k <= detail::kDirections; ++k) {  // k == kDirections: the centre
    const Vec3d place = k < detail::kDirections ? detail::spread_direction(k) * limits.workspace_radius_m : Vec3d{};
    AxisVector q = coordinates_of(kinematics, {place, {}});
    q[3] = q[4] = q[5] = 0;
    detail::widen_drives(kinematics, q, limits, bounds);
    for (unsigned turn = 0; turn < detail::kWristYaws; ++turn)
      for (const double pitch : {-kPitchLimit_rad, 0.0, kPitchLimit_rad}) {
        q[3] = turn * kHalfTurn_rad / detail::kWristYaws;
        q[kPitchAxis] = pitch;
        detail::widen_quanta(kinematics, q, quantum, bounds);
      }
  }
  bounds.position_quantum_m *= kSpreadMargin;
  bounds.rotation_quantum_rad *= kSpreadMargin;
  bounds.arm_effort_norm *= kSpreadMargin;
  for (double& effort : bounds.effort) effort *= kSpreadMargin;
  for (double& rate : bounds.rate) rate *= kSpreadMargin;
  return bounds;
}

}  // namespace tactus::hal
