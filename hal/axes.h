// From axis coordinates to the tool's pose and back-drive, and from a wrench at the tool to axis efforts.
//
// ToolKinematics is the seam: a device with an arm of its own supplies these five functions and the rest of the room
// does not change. Here: a stage with three prismatic axes and a three-axis wrist.
//   axes 0, 1, 2: x, y, z [m];  axes 3, 4, 5: yaw about z, pitch about the turned y', roll about the turned x'' [rad]
// Efforts are those that do the same work: effort . rate = wrench . twist (transpose of the Jacobian, exact).
// Frame: the device's. Units: SI. Thread: [any]; pure functions, no allocation, bounded.
// Bound: the wrist is singular at a pitch of 90 degrees; the mechanics stop at 80, and beyond that the inverse is
// taken as at 80 (finite, no longer exact), because counts from a wire may say anything.
#pragma once

#include <array>
#include <cmath>
#include <concepts>

#include "rt/base/spatial.h"

namespace tactus::hal {

inline constexpr unsigned kAxisCount = 6;
using AxisVector = std::array<double, kAxisCount>;  // m and rad, their rates, or N and N m

template <class K>
concept ToolKinematics = requires(const K kinematics, const AxisVector& q, const Wrenchd& wrench, const Twistd& twist) {
  { kinematics.pose_of(q) }
  noexcept->std::same_as<Posed>;  // device_from_tool
  { kinematics.twist_of(q, q) }
  noexcept->std::same_as<Twistd>;  // J(q) rate
  { kinematics.rates_of(q, twist) }
  noexcept->std::same_as<AxisVector>;  // J(q)^-1 twist
  { kinematics.efforts_of(q, wrench) }
  noexcept->std::same_as<AxisVector>;  // J(q)^T wrench
  { kinematics.wrench_of(q, q) }
  noexcept->std::same_as<Wrenchd>;  // J(q)^-T efforts
};

inline constexpr double kPitchLimit_rad = 80.0 * 3.14159265358979323846 / 180.0;
inline constexpr double kCosPitchLimit = 0.17364817766693034885;  // cos 80 degrees

class CartesianStage {
 public:
  Posed pose_of(const AxisVector& q) const noexcept {
    const auto yaw = sin_cos(0.5 * q[3]), pitch = sin_cos(0.5 * q[4]), roll = sin_cos(0.5 * q[5]);
    const Quatd about_z{yaw.cos, 0, 0, yaw.sin}, about_y{pitch.cos, 0, pitch.sin, 0}, about_x{roll.cos, roll.sin, 0, 0};
    return {{q[0], q[1], q[2]}, about_z * about_y * about_x};
  }

  Twistd twist_of(const AxisVector& q, const AxisVector& rate) const noexcept {
    const Wrist w(q);
    return {{rate[0], rate[1], rate[2]}, w.yaw_axis * rate[3] + w.pitch_axis * rate[4] + w.roll_axis * rate[5]};
  }

  AxisVector rates_of(const AxisVector& q, const Twistd& twist) const noexcept {
    const Wrist w(q);
    // In the frame that turned with the yaw alone, roll is the only axis with an x, pitch the only one with a y.
    const double roll_rate = dot(w.yawed_x, twist.angular) / w.cos_pitch;
    return {twist.linear.x,
            twist.linear.y,
            twist.linear.z,
            twist.angular.z + roll_rate * w.sin_pitch,
            dot(w.pitch_axis, twist.angular),
            roll_rate};
  }

  AxisVector efforts_of(const AxisVector& q, const Wrenchd& wrench) const noexcept {
    const Wrist w(q);
    return {wrench.force.x,
            wrench.force.y,
            wrench.force.z,
            dot(w.yaw_axis, wrench.torque),
            dot(w.pitch_axis, wrench.torque),
            dot(w.roll_axis, wrench.torque)};
  }

  Wrenchd wrench_of(const AxisVector& q, const AxisVector& effort) const noexcept {
    const Wrist w(q);
    const double along_yawed_x = (effort[5] + w.sin_pitch * effort[3]) / w.cos_pitch;
    return {{effort[0], effort[1], effort[2]},
            w.yawed_x * along_yawed_x + w.pitch_axis * effort[4] + w.yaw_axis * effort[3]};
  }

 private:
  // The wrist's three axes in the device's frame.
  struct Wrist {
    double sin_pitch, cos_pitch;  // cos kept away from zero
    Vec3d yaw_axis{0, 0, 1}, yawed_x, pitch_axis, roll_axis;

    explicit Wrist(const AxisVector& q) noexcept {
      const auto yaw = sin_cos(q[3]), pitch = sin_cos(q[4]);
      sin_pitch = pitch.sin;
      cos_pitch = std::abs(pitch.cos) < kCosPitchLimit ? std::copysign(kCosPitchLimit, pitch.cos) : pitch.cos;
      yawed_x = {yaw.cos, yaw.sin, 0};
      pitch_axis = {-yaw.sin, yaw.cos, 0};
      roll_axis = yawed_x * pitch.cos + yaw_axis * -pitch.sin;
    }
  };
};

static_assert(ToolKinematics<CartesianStage>);

}  // namespace tactus::hal
