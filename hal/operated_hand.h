// Target of the simulated hand while a person controls it, for example with a mouse: filters the commanded pose (the
// wish) into a motion that a hand can make.
//
// A critically damped filter of 2nd order for position and rotation, with bounds on its speeds:
//   x'' = w^2 (x_wish - x) - 2 w x',  w = kFollows_rad_per_s
// So for any wish the force on the tool stays that of a hand, k (x_target - x) + c (v_target - v). A wish is a
// displacement from the pose at begin(), so that nothing depends on how the device is placed in the scene.
// Frame: the device's. Units: SI. Thread: the simulated device's [rt]; no allocation, constant work. Bound:
// kMaxSpeed_m_per_s, kMaxTurn_rad_per_s.
#pragma once

#include <algorithm>

#include "hal/hand.h"

namespace tactus::hal {

class OperatedHand {
 public:
  static constexpr double kMaxSpeed_m_per_s = 0.5;
  static constexpr double kMaxTurn_rad_per_s = 3.0;
  // It settles in 0.2 s; a person's own hand follows a target with a bandwidth of about 5 Hz.
  static constexpr double kFollows_rad_per_s = 30.0;

  // From this target, at rest.
  void begin(const HandTarget& at) noexcept {
    target_ = {at.pose, {}};
    origin_ = wish_ = at.pose;
  }
  // Sets the wish: displaced by this from the pose at begin() [m; rotation vector, rad].
  void wish(const Vec3d& moved, const Vec3d& turned) noexcept {
    wish_ = {origin_.position + moved, quat_from_rotation_vector(turned) * origin_.rotation};
  }
  void hold() noexcept { wish_ = target_.pose; }  // where it is

  void advance(double dt_s) noexcept {
    Twistd& v = target_.twist;
    const Vec3d turn = rotation_vector_of(wish_.rotation * conjugate(target_.pose.rotation));
    v.linear = bounded(followed(wish_.position - target_.pose.position, v.linear, dt_s), kMaxSpeed_m_per_s);
    v.angular = bounded(followed(turn, v.angular, dt_s), kMaxTurn_rad_per_s);
    target_ = at(dt_s);
  }

  // `after_s`: since the last advance, within one period.
  HandTarget at(double after_s) const noexcept {
    const Posed& pose = target_.pose;
    const Quatd turned = quat_from_rotation_vector(after_s * target_.twist.angular) * pose.rotation;
    return {{pose.position + after_s * target_.twist.linear, normalized(turned)}, target_.twist};
  }

 private:
  // The speed after one step towards what is `left` to go; semi-implicit.
  static Vec3d followed(const Vec3d& left, const Vec3d& speed, double dt_s) noexcept {
    constexpr double w = kFollows_rad_per_s;
    return speed + dt_s * (w * w * left - 2 * w * speed);
  }
  static Vec3d bounded(const Vec3d& speed, double most) noexcept {
    const double size = norm(speed);
    return size > most ? (most / size) * speed : speed;
  }

  HandTarget target_;
  Posed origin_, wish_;
};

}  // namespace tactus::hal
