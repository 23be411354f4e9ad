// A six-degree-of-freedom spring and damper between a body and a moving target, solved implicitly with the contacts.
//
// Per sub-step h, with G = h (B + h K) and e the error at its start, the impulse is P = -h K e - G (v - v_target), v
// after the sub-step. So (M + G) v = M v_0 + G v_target - h K e + all other impulses: the body responds with the mass
// M + G, which contacts and joints use. The spring is no row of a sweep, and it is stable on the body's side for any
// K, B, h. The target receives the opposite impulse: the force on the device is minus the sum of the impulses over a
// step, divided by its length.
// Source: backward Euler of spring and damper, formula above; Colgate 1995 (virtual coupling). Frame: world. Units: SI.
// Thread: the owner of the World.
#pragma once

#include <cstdint>

#include "rt/base/spatial.h"
#include "rt/physics/slot_index.h"

namespace tactus::physics {

struct PoseSpring {
  bool enabled{false};
  SlotIndex slot{};  // of the body, in the world
  double stiffness_N_per_m{}, damping_Ns_per_m{};
  double stiffness_Nm_per_rad{}, damping_Nms_per_rad{};
  Posed target;            // where the target is at the start of the step
  Twistd target_velocity;  // held over the step: at sub-step j the target is at start + velocity (j + 1) h

  Wrenchd step_impulse;  // N s, N m s: sum over the step, on the body
};

// The most springs that a world can have: one per device.
inline constexpr std::uint32_t kMaxSprings = 4;

}  // namespace tactus::physics
