// Placement of the device in the scene: maps the tool's pose and twist to the world, and the world's wrench to the
// hand.
//
// Thread: [rt]; the config is set at set-up. Units: SI. Frame: `world_from_device` turns device axes to world axes.
//   position  x_w = p + s R x_d + offset        velocity  v_w = s R v_d      force on the hand   f_d = s R^T f_w
//   rotation  q_w = R q_d tool_offset           angular   w_w = R w_d        torque on the hand  t_d = R^T t_w
// Power is conserved, f_d.v_d + t_d.w_d = f_w.v_w + t_w.w_w, so the port's energy account is the same on both sides.
// Therefore the force is scaled by s: a stiffness K in the world is s^2 K at the hand, and the coupling limits apply to
// s^2 K. Clutching sets both offsets. The rotation offset is applied on the tool's side, so that it never rotates the
// axis about which the hand's motion turns the target.
// A 3-DoF device: the target keeps the orientation of its last clutch, and no torque goes to the hand.
// Bound: s > 0 and finite, checked with the scene.
#pragma once

#include <type_traits>

#include "rt/base/spatial.h"

namespace tactus::haptics {

struct DevicePlacement {
  struct Config {
    Posed world_from_device;
    double motion_scale{1};   // s: metres in the world per metre at the hand
    bool has_rotation{true};  // false: 3 DoF
  };
  struct State {
    Vec3d offset;  // m, world
    Quatd tool_offset;
  };

  Config config;
  State state;

  // Pose of the coupling's target [m], and its twist [m/s, rad/s], in the world, from those of the tool in the device
  // frame.
  Posed world_from_target(const Posed& device_from_tool) const noexcept;
  Twistd target_twist(const Twistd& tool_twist) const noexcept;
  // Wrench on the hand [N, N m, device frame] for a wrench on the target [N, N m, world].
  Wrenchd device_wrench(const Wrenchd& world_wrench) const noexcept;
  // Clutches: the tool at `device_from_tool` now maps to `world_from_target`. Re-engaging after a fault puts the target
  // on the proxy wherever the hand is: the spring starts unloaded and the force has no step.
  void clutch_to(const Posed& world_from_target, const Posed& device_from_tool) noexcept;
};

static_assert(std::is_trivially_copyable_v<DevicePlacement::State>);

}  // namespace tactus::haptics
