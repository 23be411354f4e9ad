// Kinematics of arms: a yaw axis, two links in a vertical plane that it rotates, and for WristedArm a wrist at the
// tool's centre.
//
//            upper arm, up at rest            axis 0: yaw of the whole arm about the vertical [rad]
//           |‾‾‾‾‾‾‾‾‾ forearm, level         axis 1: lean of the upper arm from the vertical, outwards [rad]
//           |         tool at the origin      axis 2: elevation of the forearm from horizontal [rad]
//   column  |                                 axes 3 to 5: the wrist on the forearm (wrist.h) [rad]
//
// Axis 2 is driven through a parallelogram: its coordinate is the forearm's absolute angle, not the elbow angle. At
// rest all coordinates are zero, the links are at right angles, the tool is at the device frame's origin with the
// frame's orientation, the column is at -x, and axes 1, 0, 2 move the tool along x, y, z: this pose is the farthest
// from all singularities. PointArm has no wrist: its tool always keeps the frame's orientation and takes no torque.
// Units: SI. Thread: [any]; pure, bounded. Bound: singular with the arm stretched or folded (elbow 90 degrees off its
// right angle, cosine 0) and with the tool above the column (radius 0). Nearer to these the inverses are computed with
// a cosine of 0.17 and a radius of a tenth of the forearm.
#pragma once

#include "hal/kinematics/wrist.h"

namespace tactus::hal {

struct ArmLinks {
  double upper_m{0.45}, forearm_m{0.45};
  friend constexpr bool operator==(const ArmLinks&, const ArmLinks&) noexcept = default;
};

// The arm without its wrist, at one configuration.
struct ArmAt {
  ArmLinks links;
  double radius, bounded_radius;   // m: horizontal distance from the column; the same, bounded away from zero
  double height_m;                 // above the shoulder
  double cos_elbow;                // cos(q1 + q2), bounded away from zero
  Vec3d outwards, tangent;         // unit, horizontal: in the arm's plane, normal to it
  Vec3d upper, forearm;            // unit, along the links
  Vec3d upper_turn, forearm_turn;  // unit: directions in which the links' ends move with axis 1, 2

  ArmAt(const AxisVector& q, const ArmLinks& arm) noexcept : links(arm) {
    const auto yaw = sin_cos(q[0]), lean = sin_cos(q[1]), rise = sin_cos(q[2]);
    outwards = {yaw.cos, yaw.sin, 0};
    tangent = {-yaw.sin, yaw.cos, 0};
    const Vec3d up{0, 0, 1};
    upper = outwards * lean.sin + up * lean.cos;
    upper_turn = outwards * lean.cos - up * lean.sin;
    forearm = outwards * rise.cos + up * rise.sin;
    forearm_turn = up * rise.cos - outwards * rise.sin;
    radius = links.upper_m * lean.sin + links.forearm_m * rise.cos;
    height_m = links.upper_m * lean.cos + links.forearm_m * rise.sin;
    bounded_radius = away_from_zero(radius, 0.1 * links.forearm_m);
    cos_elbow = away_from_zero(lean.cos * rise.cos - lean.sin * rise.sin, kCosPitchLimit);
  }

  Vec3d position() const noexcept { return outwards * radius + Vec3d{-links.forearm_m, 0, height_m - links.upper_m}; }

  Vec3d velocity(const AxisVector& rate) const noexcept {
    return tangent * (radius * rate[0]) + upper_turn * (links.upper_m * rate[1]) +
           forearm_turn * (links.forearm_m * rate[2]);
  }

  void rates(const Vec3d& velocity, AxisVector& rate) const noexcept {
    rate[0] = dot(tangent, velocity) / bounded_radius;
    rate[1] = dot(forearm, velocity) / (links.upper_m * cos_elbow);
    rate[2] = dot(upper, velocity) / (links.forearm_m * cos_elbow);
  }

  void efforts(const Vec3d& force, AxisVector& effort) const noexcept {
    effort[0] = radius * dot(tangent, force);
    effort[1] = links.upper_m * dot(upper_turn, force);
    effort[2] = links.forearm_m * dot(forearm_turn, force);
  }

  Vec3d force(const AxisVector& effort) const noexcept {
    return tangent * (effort[0] / bounded_radius) + forearm * (effort[1] / (links.upper_m * cos_elbow)) +
           upper * (effort[2] / (links.forearm_m * cos_elbow));
  }

 private:
  static double away_from_zero(double x, double least) noexcept {
    return std::abs(x) < least ? std::copysign(least, x) : x;
  }
};

class PointArm {
 public:
  explicit PointArm(const ArmLinks& links = {}) noexcept : links_(links) {}

  Posed pose_of(const AxisVector& q) const noexcept { return {ArmAt(q, links_).position(), {}}; }
  Twistd twist_of(const AxisVector& q, const AxisVector& rate) const noexcept {
    return {ArmAt(q, links_).velocity(rate), {}};
  }
  AxisVector rates_of(const AxisVector& q, const Twistd& twist) const noexcept {
    AxisVector rate{};
    ArmAt(q, links_).rates(twist.linear, rate);
    return rate;
  }
  AxisVector efforts_of(const AxisVector& q, const Wrenchd& wrench) const noexcept {
    AxisVector effort{};
    ArmAt(q, links_).efforts(wrench.force, effort);
    return effort;
  }
  Wrenchd wrench_of(const AxisVector& q, const AxisVector& effort) const noexcept {
    return {ArmAt(q, links_).force(effort), {}};
  }

 private:
  ArmLinks links_;
};

class WristedArm {
 public:
  explicit WristedArm(const ArmLinks& links = {}) noexcept : links_(links) {}

  Posed pose_of(const AxisVector& q) const noexcept {
    const auto yaw = sin_cos(0.5 * q[0]), rise = sin_cos(0.5 * q[2]);
    const Quatd forearm = Quatd{yaw.cos, 0, 0, yaw.sin} * Quatd{rise.cos, 0, -rise.sin, 0};
    return {ArmAt(q, links_).position(), forearm * wrist_rotation(q)};
  }

  Twistd twist_of(const AxisVector& q, const AxisVector& rate) const noexcept {
    const ArmAt arm(q, links_);
    return {arm.velocity(rate), forearm_spin(arm, rate) + Wrist(q, base_of(arm)).angular_velocity(rate)};
  }

  AxisVector rates_of(const AxisVector& q, const Twistd& twist) const noexcept {
    const ArmAt arm(q, links_);
    AxisVector rate{};
    arm.rates(twist.linear, rate);
    Wrist(q, base_of(arm)).rates(twist.angular - forearm_spin(arm, rate), rate);
    return rate;
  }

  AxisVector efforts_of(const AxisVector& q, const Wrenchd& wrench) const noexcept {
    const ArmAt arm(q, links_);
    AxisVector effort{};
    arm.efforts(wrench.force, effort);
    effort[0] += wrench.torque.z;
    effort[2] -= dot(arm.tangent, wrench.torque);
    Wrist(q, base_of(arm)).efforts(wrench.torque, effort);
    return effort;
  }

  Wrenchd wrench_of(const AxisVector& q, const AxisVector& effort) const noexcept {
    const ArmAt arm(q, links_);
    const Vec3d torque = Wrist(q, base_of(arm)).torque(effort);
    AxisVector for_force = effort;  // the arm's efforts without the part that supports the wrist's torque
    for_force[0] -= torque.z;
    for_force[2] += dot(arm.tangent, torque);
    return {arm.force(for_force), torque};
  }

 private:
  static WristBase base_of(const ArmAt& arm) noexcept { return {arm.forearm, arm.tangent, arm.forearm_turn}; }
  static Vec3d forearm_spin(const ArmAt& arm, const AxisVector& rate) noexcept {
    return Vec3d{0, 0, rate[0]} - arm.tangent * rate[2];
  }

  ArmLinks links_;
};

static_assert(ToolKinematics<PointArm> && ToolKinematics<WristedArm>);

}  // namespace tactus::hal
