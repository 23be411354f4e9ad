// A joint between two bodies: its parameters, and its state between steps.
//
// It has a frame on each body. The coordinate is 0 where the frames coincide; the joint's axis is their z:
//  fixed     no relative motion
//  ball      the frames' origins coincide
//  hinge     same, and B rotates about A's z only; the coordinate is the angle [rad], in (-pi, pi]
//  slider    B moves along A's z only and does not rotate; the coordinate is the distance along it [m]
//  distance  the coordinate is the distance of the origins [m], within the limits; equal limits: a rod
// Plain values. Frame: see each field. Units: SI. Thread: [any].
#pragma once

#include <limits>

#include "rt/base/ids.h"
#include "rt/base/spatial.h"

namespace tactus::physics {

enum class JointKind : std::uint32_t { kFixed = 0, kBall = 1, kHinge = 2, kSlider = 3, kDistance = 4 };

struct Joint {
  JointKind kind{JointKind::kFixed};
  BodyId a{kNoBody};   // kNoBody: the world
  BodyId b{kNoBody};   // a moving body
  Posed a_from_joint;  // the frame on A; in the world frame if A is the world
  Posed b_from_joint;  // the frame on B
  bool bodies_collide{false};
  bool limited{false};                                              // for a hinge (within (-pi, pi)), slider, distance
  double low{}, high{};                                             // limits of the coordinate
  bool driven{false};                                               // hinge, slider: a motor
  double motor_speed{};                                             // rad/s, m/s, of the coordinate
  double motor_effort{};                                            // N m, N: largest effort of the motor
  double break_force_N{std::numeric_limits<double>::infinity()};    // N: breaks for good above this mean over a step
  double break_torque_Nm{std::numeric_limits<double>::infinity()};  // N m: same for the torque
};

// Effort in the joint's axes (A's frame), on B. Within a step: impulses of a sub-step [N s, N m s]; between steps:
// forces [N, N m], because the sub-step may change.
struct JointEffort {
  Vec3d linear, angular;
  double drive{}, lower{}, upper{};  // along or about the axis: motor; rod or lower limit; upper limit

  friend constexpr JointEffort operator*(double s, const JointEffort& e) noexcept {
    return {.linear = s * e.linear,
            .angular = s * e.angular,
            .drive = s * e.drive,
            .lower = s * e.lower,
            .upper = s * e.upper};
  }
  friend constexpr JointEffort operator+(const JointEffort& p, const JointEffort& q) noexcept {
    return {.linear = p.linear + q.linear,
            .angular = p.angular + q.angular,
            .drive = p.drive + q.drive,
            .lower = p.lower + q.lower,
            .upper = p.upper + q.upper};
  }
};

struct JointState {
  JointEffort effort;       // warm-starts the next step
  Vec3d force, torque;      // N, N m, world: on B, at its frame; mean over the last step
  double coordinate{};      // at the end of the last step
  std::uint32_t broken{0};  // 1: permanently broken
};

}  // namespace tactus::physics
