// Kinematics of a wrist with three axes that intersect in the tool's centre: yaw about its base's z, pitch about the
// rotated y', roll about the rotated x''. Coordinates, rates and efforts are those of axes 3, 4 and 5.
//
// Frame: the device's; the base is given by its axes in that frame. Units: rad, rad/s, N m. Thread: [any], pure,
// bounded. Bound: singular at a pitch of 90 degrees; the mechanical stop is at 80, beyond it the inverse uses cos 80.
#pragma once

#include <cmath>

#include "hal/kinematics/tool_kinematics.h"

namespace tactus::hal {

inline constexpr double kPitchLimit_rad = 80.0 * 3.14159265358979323846 / 180.0;
inline constexpr double kCosPitchLimit = 0.17364817766693034885;  // cos 80 degrees
inline constexpr unsigned kPitchAxis = 4;

struct WristBase {
  Vec3d x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};
};

inline Quatd wrist_rotation(const AxisVector& q) noexcept {  // base_from_tool
  const auto yaw = sin_cos(0.5 * q[3]), pitch = sin_cos(0.5 * q[4]), roll = sin_cos(0.5 * q[5]);
  const Quatd about_z{yaw.cos, 0, 0, yaw.sin}, about_y{pitch.cos, 0, pitch.sin, 0}, about_x{roll.cos, roll.sin, 0, 0};
  return about_z * about_y * about_x;
}

struct Wrist {
  double sin_pitch, cos_pitch;  // cos bounded away from zero
  Vec3d yaw_axis, yawed_x, pitch_axis, roll_axis;

  Wrist(const AxisVector& q, const WristBase& base) noexcept : yaw_axis(base.z) {
    const auto yaw = sin_cos(q[3]), pitch = sin_cos(q[4]);
    sin_pitch = pitch.sin;
    cos_pitch = std::abs(pitch.cos) < kCosPitchLimit ? std::copysign(kCosPitchLimit, pitch.cos) : pitch.cos;
    yawed_x = base.x * yaw.cos + base.y * yaw.sin;
    pitch_axis = base.y * yaw.cos - base.x * yaw.sin;
    roll_axis = yawed_x * pitch.cos - yaw_axis * pitch.sin;
  }

  // Of the tool relative to the base, rad/s.
  Vec3d angular_velocity(const AxisVector& rate) const noexcept {
    return yaw_axis * rate[3] + pitch_axis * rate[4] + roll_axis * rate[5];
  }

  // In the frame rotated by yaw only, the roll axis is the only one with an x component, pitch the only one with a y.
  void rates(const Vec3d& angular_velocity, AxisVector& rate) const noexcept {
    rate[5] = dot(yawed_x, angular_velocity) / cos_pitch;
    rate[4] = dot(pitch_axis, angular_velocity);
    rate[3] = dot(yaw_axis, angular_velocity) + rate[5] * sin_pitch;
  }

  void efforts(const Vec3d& torque, AxisVector& effort) const noexcept {
    effort[3] = dot(yaw_axis, torque);
    effort[4] = dot(pitch_axis, torque);
    effort[5] = dot(roll_axis, torque);
  }

  Vec3d torque(const AxisVector& effort) const noexcept {
    const double along_yawed_x = (effort[5] + sin_pitch * effort[3]) / cos_pitch;
    return yawed_x * along_yawed_x + pitch_axis * effort[4] + yaw_axis * effort[3];
  }
};

}  // namespace tactus::hal
