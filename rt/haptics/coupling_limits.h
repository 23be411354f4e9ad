// How stiff and how damped the device-proxy coupling may be, from the device's description. For set-up: the loop
// refuses gains that the rules below refuse, and the tools print the numbers; `tactus experiment stability-map`
// measures where they are right.
//
// Thread: [any], pure. Units: SI, in the names. b, m: the device's own damping and mass at the tool; T: period;
// t_d: delay beyond the sample-and-hold, lateness of the tick included; K, B: the coupling's stiffness and damping;
// f_c: the device's Coulomb friction; q: its quantum. The same formulas hold for rotation with N m/rad, N m s/rad,
// kg m^2, rad.
//   stable       1 + L(z) = 0 on the unit circle   uncoupled stability, no hand: a mass under held force, a backward
//                                              difference, t_d. For a little damping it is the well-known line
//                                              K < (b + B) / (T/2 + t_d) (Gil, Avello, Rubio, Florez 2004; with delay:
//                                              Hulin, Preusche, Hirzinger 2008); it bends down where B T / m is not
//                                              small, and comes to 0 where the damper alone is unstable
//   damper       B <= 0.5 m / T                a sampled damper on a free mass. With the backward difference, the hold
//   and
//                                              one period of delay its poles are the roots of z^3 - z^2 + (c/2)(z + 1),
//                                              c = B T/m: stable for c < 2 (sqrt 2 - 1) = 0.83. 0.5 is a margin of 1.66
//   certificate  K < 2 (b - |B|) / T           passive for every passive hand: Colgate, Schenkel 1997, b > K T/2 + |B|
//   quantised    K <= min(2 b / T, 2 f_c / q)  no limit cycle from the encoder: Abbott, Okamura 2005
// The loop's own coupling moves its target on while a tick is solved, at the speed of the sample: its force is
// `lead_s`, half a tick and half a sub-step, ahead, which is K lead_s more damping than the scene's. set-up leaves that
// as a margin and judges with lead_s = 0; with it the first formula says where that loop rings, and its line is (b + B)
// / (T/2 + t_d - lead). Hard case 30 measures both. Only the first two refuse, and a damper that makes 0.06 N of one
// quantum: the certificate holds for none that is worth having (it needs B < b), which is why a passivity controller
// stands behind the coupling.
#pragma once

#include "rt/haptics/coupling/coupling_gains.h"
#include "rt/haptics/device.h"

namespace tactus::haptics {

// The share of the limit that is allowed. The limit is that of a simulated mass within 3 %; a proxy that is no rigid
// wall, a device description that is off and a delay that varies take the rest.
inline constexpr double kAllowedStiffnessShare = 0.56;

// One axis' device, and what is asked of it. Translation in N/m, N s/m, kg, N, m; rotation in N m/rad and so on.
struct AxisLimits {
  double period_s{1e-3}, delay_s{0};
  double mass{0}, damping{0}, coulomb_friction{0}, quantum{0};
  double lead_s{0};  // by which the coupling's target runs ahead of the sample, on average over the tick
};

// Of the axes of a device whose ticks are late by up to `late_s`: a delay of half of it, the mean.
AxisLimits translation_of(const DeviceProperties& device, double period_s, double late_s = 0) noexcept;
AxisLimits rotation_of(const DeviceProperties& device, double period_s, double late_s = 0) noexcept;

// The stiffness above which a push grows; 0 where the damping alone is too much, and for a device without mass.
double uncoupled_stiffness_limit(const AxisLimits& axis, double coupling_damping) noexcept;
// Its line for a little damping, (b + B) / (T/2 + t_d - lead); infinite where the lead is all of the delay.
double little_damping_limit(const AxisLimits& axis, double coupling_damping) noexcept;
double damping_limit(const AxisLimits& axis) noexcept;
double passive_stiffness_limit(const AxisLimits& axis, double coupling_damping) noexcept;  // <= 0: none is passive
double quantisation_stiffness_limit(
    const AxisLimits& axis) noexcept;  // a device without friction: 0, none is free of it

struct AxisVerdict {
  double stiffness{0}, damping{0};  // asked for
  double stiffness_limit{0};        // uncoupled stability
  double stiffness_allowed{0};      // kAllowedStiffnessShare of it: what is accepted
  double margin{0};                 // limit / stiffness; infinite for no stiffness
  double damping_limit{0};
  double passive_limit{0};  // certificate
  double quantisation_limit{0};
  bool passive{false};               // the certificate holds
  bool free_of_limit_cycles{false};  // the quantisation limit holds
  bool accepted{false};              // not above stiffness_allowed and damping_limit; finite and not negative
};

struct CouplingVerdict {
  AxisVerdict translation, rotation;  // rotation of a 3-DoF device: not judged, accepted
  bool accepted{false};
};

// `late_s`: up to how late ticks wake, by the machine's own measurement; half of it delays the force as the link does.
CouplingVerdict check_coupling(const CouplingGains& gains, const DeviceProperties& device, double period_s,
                               double late_s = 0) noexcept;

// What to use on this device: damping that makes 0.0125 N (0.6 N mm) of one quantum in the estimator's window, and
// the stiffness that is allowed with it, less 2 %. Of a 3-DoF device the rotation's are the defaults.
CouplingGains suggest_gains(const DeviceProperties& device, double period_s, double late_s = 0) noexcept;

}  // namespace tactus::haptics
