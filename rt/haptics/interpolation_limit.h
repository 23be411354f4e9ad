// Stiffness limit of the interpolation coupling, below the limit that applies to every coupling.
//
// The proxy that the device feels is r ticks old and reacts to device poses up to r ticks older than that. So beside
// the loop of the device on its spring (coupling_limits.h) there is a loop through the global world, with a delay of
// t_d + r T. While the proxy's contacts do not change, this loop is linear and periodic with the cycle: device, delay
// line, held targets, proxy and interpolation form one state vector, and a cycle is one matrix. The coupling is stable
// if the powers of that matrix go to zero, for the proxy's own mass and for every larger one (it pushes what it
// touches; a proxy that cannot move is a wall, see coupling_limits.h). The limit is found by a search over the
// stiffness. The law of coupling_limits.h with this delay, (b + B) / (T/2 + t_d + r T), is sufficient but too strict:
// the limit is 1.6 to 3.3 times as high (0.3 kg, B 1 to 20 N s/m, ratios 2 to 32), since the loop through the world
// carries the difference of two positions, on which a delay has little effect at low frequencies. Not modelled: the
// hand and dry friction, as in coupling_limits.h, and the coupling of rotation and translation by contacts off the
// centre. kAllowedStiffnessShare of the limit is allowed, as for every coupling. Thread: [any], pure; takes some 10 ms
// at a ratio of 10: for set-up. Units: SI; for rotation N m/rad and so on. Bound: a delay above kMaxDelayTicks is
// treated as kMaxDelayTicks.
#pragma once

#include "rt/haptics/coupling_limits.h"

namespace tactus::haptics {

inline constexpr std::uint32_t kMaxDelayTicks = 32;

// The proxy in the global world, in the device's units: its mass at the hand is motion_scale^2 times that in the world.
struct InterpolatedProxy {
  double mass{0};                     // kg, or kg m^2
  std::uint32_t ratio{1};             // ticks per global step
  std::uint32_t global_sub_steps{1};  // of a global step
};

// True if oscillations decay with these gains and a proxy of exactly this mass.
bool interpolation_is_stable(const AxisLimits& axis, const InterpolatedProxy& proxy, double stiffness,
                             double damping) noexcept;

// Stiffness [N/m, N m/rad] above which an oscillation may grow with this damping [N s/m, N m s/rad]; at most
// uncoupled_stiffness_limit. 0: the damping alone is unstable.
double interpolation_stiffness_limit(const AxisLimits& axis, const InterpolatedProxy& proxy, double damping) noexcept;

}  // namespace tactus::haptics
