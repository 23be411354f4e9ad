// Limits of the stiffness and damping of the device-proxy coupling, from the device's description. For set-up: the loop
// refuses gains that the rules below refuse, and the tools print the numbers; `tactus experiment stability-map`
// measures where they hold.
//
// Thread: [any], pure. Units: SI, in the names. b, m: the device's own damping and mass at the tool; T: period;
// t_d: delay beyond the sample-and-hold, lateness of the tick included; K, B: the coupling's stiffness and damping;
// f_c: the device's Coulomb friction; q: its quantum. The same formulas hold for rotation with N m/rad, N m s/rad,
// kg m^2, rad.
//   stable       1 + L(z) = 0 on the unit circle
//                Uncoupled stability, without a hand: a mass under held force, a backward difference, t_d. For small
//                damping it is the line K < (b + B) / (T/2 + t_d) (Gil, Avello, Rubio, Florez 2004; with delay: Hulin,
//                Preusche, Hirzinger 2008); the limit is below this line where B T / m is not small, and reaches 0
//                where the damper alone is unstable.
//   damper       B <= 0.5 m / T
//                A sampled damper on a free mass. With the backward difference, the hold and one period of delay its
//                poles are the roots of z^3 - z^2 + (c/2)(z + 1), c = B T/m: stable for c < 2 (sqrt 2 - 1) = 0.83.
//                0.5 is a margin of 1.66.
//   certificate  K < 2 (b - |B|) / T
//                Passive for every passive hand: Colgate, Schenkel 1997, b > K T/2 + |B|.
//   quantised    K <= min(2 b / T, 2 f_c / q)
//                No limit cycle from the encoder: Abbott, Okamura 2005.
// The loop's coupling extrapolates its target while a tick is solved, at the speed of the sample: its force leads by
// `lead_s`, half a tick and half a sub-step, which adds K lead_s to the scene's damping. Set-up keeps that as a margin
// and judges with lead_s = 0. With the loop's lead_s the first formula gives the stiffness at which the loop rings, and
// its line is (b + B) / (T/2 + t_d - lead). Hard case 30 measures both. Gains are refused only by the first two rules
// and by a damper that makes 0.06 N of one quantum. The certificate needs B < b, which no useful coupling satisfies:
// therefore a passivity controller follows the coupling.
#pragma once

#include "rt/haptics/coupling/coupling_gains.h"
#include "rt/haptics/device.h"

namespace tactus::haptics {

// Share of the limit that is allowed. The limit is that of a simulated mass within 3 %; the rest covers a proxy that is
// not a rigid wall, an inaccurate device description and a varying delay.
inline constexpr double kAllowedStiffnessShare = 0.56;

// One axis of the device. Translation in N/m, N s/m, kg, N, m; rotation in N m/rad and so on.
struct AxisLimits {
  double period_s{1e-3}, delay_s{0};
  double mass{0}, damping{0}, coulomb_friction{0}, quantum{0};
  double lead_s{0};  // lead of the coupling's target over the sample, mean over the tick
};

// The axes of a device whose ticks are late by up to `late_s`: half of it, the mean, is added to the delay.
AxisLimits translation_of(const DeviceProperties& device, double period_s, double late_s = 0) noexcept;
AxisLimits rotation_of(const DeviceProperties& device, double period_s, double late_s = 0) noexcept;

// Stiffness above which an oscillation grows; 0 if the damping alone is unstable, and for a device without mass.
double uncoupled_stiffness_limit(const AxisLimits& axis, double coupling_damping) noexcept;
// The line for small damping, (b + B) / (T/2 + t_d - lead); infinite if the lead is at least T/2 + t_d.
double little_damping_limit(const AxisLimits& axis, double coupling_damping) noexcept;
double damping_limit(const AxisLimits& axis) noexcept;
double passive_stiffness_limit(const AxisLimits& axis,
                               double coupling_damping) noexcept;  // <= 0: no stiffness is passive
double quantisation_stiffness_limit(
    const AxisLimits& axis) noexcept;  // 0 for a device without friction: limit cycles at any stiffness

struct AxisVerdict {
  double stiffness{0}, damping{0};  // requested
  double stiffness_limit{0};        // uncoupled stability
  double stiffness_allowed{0};      // kAllowedStiffnessShare * stiffness_limit: accepted up to here
  double margin{0};                 // limit / stiffness; infinite for no stiffness
  double damping_limit{0};
  double passive_limit{0};  // certificate
  double quantisation_limit{0};
  bool passive{false};               // the certificate holds
  bool free_of_limit_cycles{false};  // the quantisation limit holds
  bool accepted{false};              // within stiffness_allowed and damping_limit; finite and not negative
};

struct CouplingVerdict {
  AxisVerdict translation, rotation;  // rotation of a 3-DoF device: not judged, accepted
  bool accepted{false};
};

// `late_s`: measured lateness of the ticks on this machine; half of it is added to the link's delay.
CouplingVerdict check_coupling(const CouplingGains& gains, const DeviceProperties& device, double period_s,
                               double late_s = 0) noexcept;

// Gains for this device: damping that makes 0.0125 N (0.6 N mm) of one quantum in the estimator's window, and the
// allowed stiffness at that damping, less 2 %. Rotation of a 3-DoF device: the defaults.
CouplingGains suggest_gains(const DeviceProperties& device, double period_s, double late_s = 0) noexcept;

}  // namespace tactus::haptics
