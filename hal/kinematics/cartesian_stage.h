// A stage with three prismatic axes and a three-axis wrist: axes 0, 1, 2 are x, y, z [m], 3 to 5 the wrist's [rad].
// Frame: the device's. Units: SI. Thread: [any], pure, bounded. Singular where the wrist is (wrist.h).
#pragma once

#include "hal/kinematics/wrist.h"

namespace tactus::hal {

class CartesianStage {
 public:
  Posed pose_of(const AxisVector& q) const noexcept { return {{q[0], q[1], q[2]}, wrist_rotation(q)}; }

  Twistd twist_of(const AxisVector& q, const AxisVector& rate) const noexcept {
    return {{rate[0], rate[1], rate[2]}, Wrist(q, {}).angular_velocity(rate)};
  }

  AxisVector rates_of(const AxisVector& q, const Twistd& twist) const noexcept {
    AxisVector rate{twist.linear.x, twist.linear.y, twist.linear.z, 0, 0, 0};
    Wrist(q, {}).rates(twist.angular, rate);
    return rate;
  }

  AxisVector efforts_of(const AxisVector& q, const Wrenchd& wrench) const noexcept {
    AxisVector effort{wrench.force.x, wrench.force.y, wrench.force.z, 0, 0, 0};
    Wrist(q, {}).efforts(wrench.torque, effort);
    return effort;
  }

  Wrenchd wrench_of(const AxisVector& q, const AxisVector& effort) const noexcept {
    return {{effort[0], effort[1], effort[2]}, Wrist(q, {}).torque(effort)};
  }
};

static_assert(ToolKinematics<CartesianStage>);

}  // namespace tactus::hal
