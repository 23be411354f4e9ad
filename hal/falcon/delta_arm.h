// Kinematics of the Novint Falcon: three parallel legs that move its grip without turning it (a delta robot).
//
// Axis i is the angle of leg i's thigh, measured from its angle at the workspace's centre. In the maker's frame x is to
// the right, y up and z towards the person; here the device's frame is that of tactus: x to the right, y away from the
// person, z up, the origin at z = 0.125 m of the maker's, the middle of the workspace. Per leg at azimuth phi, with the
// foot's offsets r and s: u = x cos phi + y sin phi - r, v = y cos phi - x sin phi - s, w = z, and the shin's angles
// theta2 in the plane of the thigh, theta3 out of it. Geometry: libnifalcon's figures (BSD licence), on which other
// drivers build; the inverse agrees with its half-angle form, the Jacobian is the derivative of the inverse (its
// shipped third column, sin^2 theta2 sin theta3, is not). Units: SI. Thread: [any]; pure, bounded. Bound: near a
// stretched or folded leg the inverses are bounded, not exact.
#pragma once

#include <algorithm>
#include <cmath>

#include "hal/kinematics/tool_kinematics.h"

namespace tactus::hal {

class DeltaArm {
 public:
  static constexpr double kWorkspaceRadius_m = 0.05;  // of the tool about the centre
  // rad of an axis per encoder count: 1280 counts a turn of a capstan of 14.25 mm on a sector of 110 mm.
  static constexpr double kCount_rad = 6.359e-4;
  static constexpr double kZeroCount_rad = 35.0 * 3.14159265358979323846 / 180.0;  // thigh angle at count 0

  struct Leg {
    double theta1{0};  // rad
    Vec3d gradient;    // d theta1 / d position, maker's frame, rad/m
  };

  // Maker's frame, absolute angle. At a position that a leg does not reach: the nearest that is computable.
  static Leg leg_at(unsigned leg, const Vec3d& position) noexcept {
    constexpr double kThigh = 0.060, kShin = 0.1025, kC = 0.01443, kD = 0.01125, kE = 0.01125, kF = -0.025;
    constexpr double kR = 0.0400, kS = -0.02309, kDegree = 3.14159265358979323846 / 180.0;
    constexpr double kAzimuth[3] = {105 * kDegree, -15 * kDegree, -135 * kDegree};
    const auto phi = sin_cos(kAzimuth[leg]);
    const double u = phi.cos * position.x + phi.sin * position.y - kR;
    const double v = -phi.sin * position.x + phi.cos * position.y - kS, w = position.z;
    const double cos3 = std::clamp((v + kF) / kShin, -0.999, 0.999), sin3 = std::sqrt(1 - cos3 * cos3);
    const double shin_length = kShin * sin3 + kD + kE, out = u + kC;
    const double squares = std::max(out * out + w * w, 1e-6), distance = std::sqrt(squares);
    const double cosine = (squares + kThigh * kThigh - shin_length * shin_length) / (2 * kThigh * distance);
    Leg found;
    found.theta1 = std::atan2(w, out) - std::acos(std::clamp(cosine, -0.999, 0.999));
    const auto thigh = sin_cos(found.theta1);
    const double theta2 = std::atan2(w - kThigh * thigh.sin, out - kThigh * thigh.cos);
    const auto shin = sin_cos(theta2), bend = sin_cos(theta2 - found.theta1);
    const double bent = std::abs(bend.sin) < 0.05 ? std::copysign(0.05, bend.sin) : bend.sin;
    found.gradient =
        Vec3d{phi.cos * shin.cos * sin3 - phi.sin * cos3, phi.sin * shin.cos * sin3 + phi.cos * cos3, shin.sin * sin3} *
        (1.0 / (kThigh * sin3 * bent));
    return found;
  }

  // The position of these axis coordinates, maker's frame, by Newton from `start`. False: none was found in kSteps.
  static bool solve(const AxisVector& q, Vec3d& position) noexcept {
    constexpr int kSteps = 8;
    constexpr double kClose_rad = 1e-9, kLongest_m = 0.04;
    for (int step = 0; step <= kSteps; ++step) {
      const Legs legs(position);
      const Vec3d error{q[0] + centre_angle() - legs.leg[0].theta1, q[1] + centre_angle() - legs.leg[1].theta1,
                        q[2] + centre_angle() - legs.leg[2].theta1};
      if (std::max({std::abs(error.x), std::abs(error.y), std::abs(error.z)}) < kClose_rad) return true;
      if (step == kSteps) return false;
      Vec3d way = legs.inverse(error);
      const double length = norm(way);
      if (!std::isfinite(length)) return false;
      if (length > kLongest_m) way = way * (kLongest_m / length);
      position += way;
    }
    return false;
  }

  static AxisVector axes_of(const Vec3d& device_position) noexcept {
    const Vec3d at = maker_from_device(device_position);
    AxisVector q{};
    for (unsigned i = 0; i < 3; ++i) q[i] = leg_at(i, at).theta1 - centre_angle();
    return q;
  }

  static double centre_angle() noexcept {
    static const double kAngle = leg_at(0, {0, 0, kCentre_m}).theta1;
    return kAngle;
  }
  static Vec3d maker_from_device(const Vec3d& p) noexcept { return {p.x, p.z, kCentre_m - p.y}; }
  static Vec3d device_from_maker(const Vec3d& p) noexcept { return {p.x, kCentre_m - p.z, p.y}; }

  // --- ToolKinematics. pose_of begins at the centre.
  Posed pose_of(const AxisVector& q) const noexcept { return {device_from_maker(position_of(q)), {}}; }
  Twistd twist_of(const AxisVector& q, const AxisVector& rate) const noexcept {
    return {turned_to_device(Legs(position_of(q)).inverse({rate[0], rate[1], rate[2]})), {}};
  }
  AxisVector rates_of(const AxisVector& q, const Twistd& twist) const noexcept {
    const Legs legs(position_of(q));
    const Vec3d velocity = turned_to_maker(twist.linear);
    return {dot(legs.leg[0].gradient, velocity),
            dot(legs.leg[1].gradient, velocity),
            dot(legs.leg[2].gradient, velocity),
            0,
            0,
            0};
  }
  // J^-T F, with J = d theta / d x.
  AxisVector efforts_of(const AxisVector& q, const Wrenchd& wrench) const noexcept {
    const Vec3d effort = Legs(position_of(q)).inverse_transposed(turned_to_maker(wrench.force));
    return {effort.x, effort.y, effort.z, 0, 0, 0};
  }
  Wrenchd wrench_of(const AxisVector& q, const AxisVector& effort) const noexcept {
    const Legs legs(position_of(q));
    const Vec3d force =
        legs.leg[0].gradient * effort[0] + legs.leg[1].gradient * effort[1] + legs.leg[2].gradient * effort[2];
    return {turned_to_device(force), {}};
  }

 private:
  static constexpr double kCentre_m = 0.125;

  struct Legs {
    Leg leg[3];
    Vec3d column[3];  // of the inverse of the Jacobian
    explicit Legs(const Vec3d& position) noexcept {
      for (unsigned i = 0; i < 3; ++i) leg[i] = leg_at(i, position);
      const Vec3d &a = leg[0].gradient, &b = leg[1].gradient, &c = leg[2].gradient;
      const double determinant = dot(a, cross(b, c));
      constexpr double kLeast = 1;  // (rad/m)^3; in the workspace it is beyond 1000
      const double bounded = std::abs(determinant) < kLeast ? std::copysign(kLeast, determinant) : determinant;
      column[0] = cross(b, c) * (1.0 / bounded);
      column[1] = cross(c, a) * (1.0 / bounded);
      column[2] = cross(a, b) * (1.0 / bounded);
    }
    Vec3d inverse(const Vec3d& rate) const noexcept {
      return column[0] * rate.x + column[1] * rate.y + column[2] * rate.z;
    }
    Vec3d inverse_transposed(const Vec3d& force) const noexcept {
      return {dot(column[0], force), dot(column[1], force), dot(column[2], force)};
    }
  };

  static Vec3d position_of(const AxisVector& q) noexcept {
    Vec3d position{0, 0, kCentre_m};
    (void)solve(q, position);
    return position;
  }
  static Vec3d turned_to_maker(const Vec3d& v) noexcept { return {v.x, v.z, -v.y}; }
  static Vec3d turned_to_device(const Vec3d& v) noexcept { return {v.x, -v.z, v.y}; }
};

static_assert(ToolKinematics<DeltaArm>);

}  // namespace tactus::hal
