// How stiff the interpolation coupling may be: its own limit, below the one that every coupling has.
//
// The proxy that the device feels is r ticks old, and answers to where the device was up to r ticks before that. So
// beside the device on its spring (coupling_limits.h) there is a loop through the global world, with a delay of
// t_d + r T. It is linear while the proxy's contacts do not change, and the same in every cycle: device, delay line,
// held targets, proxy and interpolation are one state vector, and a cycle is one matrix. The coupling is stable where
// the powers of that matrix go to zero, for a proxy of its own mass and of any larger one (it pushes what it touches;
// one that cannot move at all is a wall, which coupling_limits.h judges). That is asked of one stiffness after the
// other. The law of coupling_limits.h with this delay, (b + B) / (T/2 + t_d + r T), is sufficient but asks for too
// much: the limit is 1.6 to 3.3 times as high (0.3 kg, B 1 to 20 N s/m, ratios 2 to 32), since the loop through the
// world carries the difference of two positions, which a delay hardly changes where frequencies are low. Left out, as
// in coupling_limits.h: the hand, dry friction. Also the coupling of turning and moving by contacts off the centre.
// kAllowedStiffnessShare of the limit is allowed, as for every coupling. Thread: [any], pure; takes some 10 ms at a
// ratio of 10: for set-up. Units: SI; for rotation N m/rad and so on. Bound: a delay of kMostDelayTicks and more is
// taken as that many.
#pragma once

#include "rt/haptics/coupling_limits.h"

namespace tactus::haptics {

inline constexpr std::uint32_t kMostDelayTicks = 32;

// The proxy in the global world. In the device's units: at the hand its mass is motion_scale^2 of the world's.
struct InterpolatedProxy {
  double mass{0};                     // kg, or kg m^2
  std::uint32_t ratio{1};             // ticks per global step
  std::uint32_t global_sub_steps{1};  // of a global step
};

// True where an oscillation dies out with these gains and a proxy of just this mass.
bool interpolation_is_stable(const AxisLimits& axis, const InterpolatedProxy& proxy, double stiffness,
                             double damping) noexcept;

// The stiffness above which an oscillation may grow, with this damping; at most uncoupled_stiffness_limit. 0 where the
// damping alone is too much.
double interpolation_stiffness_limit(const AxisLimits& axis, const InterpolatedProxy& proxy, double damping) noexcept;

}  // namespace tactus::haptics
