// A joint between two bodies: what it is, and what it holds from step to step.
//
// It has a frame on either body. Where the frames agree the joint is at rest at coordinate 0; its axis is their z:
//   fixed     nothing moves
//   ball      the frames' origins stay together
//   hinge     same, and B turns about A's z only; the coordinate is the angle [rad], in (-pi, pi]
//   slider    B moves along A's z only and does not turn; the coordinate is the distance along it [m]
//   distance  the coordinate is the distance of the origins [m], within the limits; equal limits: a rod
// Plain values. Frame: as each field says. Units: SI. Thread: [any].
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
  Posed a_from_joint;  // the frame on A; in the world where A is
  Posed b_from_joint;  // the frame on B
  bool bodies_collide{false};
  bool limited{false};                                              // hinge within (-pi, pi), slider, distance
  double low{}, high{};                                             // of the coordinate
  bool driven{false};                                               // hinge, slider: a motor
  double motor_speed{};                                             // rad/s, m/s, of the coordinate
  double motor_effort{};                                            // N m, N: at most
  double break_force_N{std::numeric_limits<double>::infinity()};    // the mean over a step that breaks it, for good
  double break_torque_Nm{std::numeric_limits<double>::infinity()};  // same
};

// In the joint's axes (A's frame), on B. Of a sub-step: impulses [N s, N m s]; between steps: forces [N, N m], because
// sub-steps differ.
struct JointEffort {
  Vec3d linear, angular;
  double drive{}, lower{}, upper{};  // along the axis, or about it: motor or rod; limits

  friend constexpr JointEffort operator*(double s, const JointEffort& e) noexcept {
    return {s * e.linear, s * e.angular, s * e.drive, s * e.lower, s * e.upper};
  }
  friend constexpr JointEffort operator+(const JointEffort& p, const JointEffort& q) noexcept {
    return {p.linear + q.linear, p.angular + q.angular, p.drive + q.drive, p.lower + q.lower, p.upper + q.upper};
  }
};

struct JointState {
  JointEffort effort;       // starts the next step
  Vec3d force, torque;      // N, N m, world: on B, at its frame; mean over the last step
  double coordinate{};      // at the end of the last step
  std::uint32_t broken{0};  // 1: for good
};

}  // namespace tactus::physics
