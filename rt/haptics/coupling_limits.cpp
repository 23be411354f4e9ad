#include "rt/haptics/coupling_limits.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "rt/base/math.h"
#include "rt/haptics/velocity_estimator.h"

namespace tactus::haptics {
namespace {

// Force that the damper makes of one quantum, B q / (N T) with the estimator's window of N ticks: the level that a hand
// does not notice (N; N m), and the factor above it (5) beyond which the damper may keep responding to its own quanta.
// Measured with quanta of 10 to 50 um at 1 kHz: up to there a tap of 1 N decays at the allowed stiffness; at twice that
// damping it may not; at six times it does not decay at any stiffness.
constexpr double kQuietForce_N = 0.0125, kQuietTorque_Nm = 6e-4;
constexpr double kLoudestOfQuiet = 5;

// Damping at which one quantum makes `force`; infinite for a device without a quantum.
double damping_of_quantum(const AxisLimits& axis, double force) noexcept {
  const double window = VelocityEstimator::Config::of({}, axis.period_s).window;
  return axis.quantum > 0 ? force * window * axis.period_s / axis.quantum : std::numeric_limits<double>::infinity();
}

struct Gains {
  double stiffness, damping;
};

// Gains of the stability boundary for an oscillation of `angle` per period, from real and imaginary part of
//   1 + (K + B (1 - 1/z) / T) z^(-t_d/T) G(z) = 0 at z = e^(i angle).
// G: transfer function from held force to position.
Gains on_boundary(const AxisLimits& axis, double angle) noexcept {
  using Complex = std::complex<double>;
  const double T = axis.period_s, m = axis.mass, b = axis.damping;
  const auto [sine, cosine] = sin_cos(angle);
  const auto [late_sine, late_cosine] = sin_cos(angle * axis.delay_s / T);
  const Complex z{cosine, sine}, late{late_cosine, late_sine};
  const double a = b * T / m, decay = (1 - 0.5 * a) / (1 + 0.5 * a);
  // Below 1e-6 the two terms of the damped mass would cancel.
  const Complex G = a < 1e-6 ? T * T / (2 * m) * (z + 1.0) / ((z - 1.0) * (z - 1.0))
                             : (T / (z - 1.0) - (m / b) * (1 - decay) / (z - decay)) / b;
  const Complex wanted = -late / G;
  const double damping = T * wanted.imag() / sine;
  return {wanted.real() - damping / T * (1 - cosine), damping};
}

AxisVerdict judge(const AxisLimits& axis, double stiffness, double damping, double quiet) noexcept {
  AxisVerdict v;
  v.stiffness = stiffness;
  v.damping = damping;
  v.stiffness_limit = uncoupled_stiffness_limit(axis, damping);
  v.stiffness_allowed = kAllowedStiffnessShare * v.stiffness_limit;
  v.margin = stiffness > 0 ? v.stiffness_limit / stiffness : std::numeric_limits<double>::infinity();
  v.damping_limit = std::min(damping_limit(axis), damping_of_quantum(axis, kLoudestOfQuiet * quiet));
  v.passive_limit = passive_stiffness_limit(axis, damping);
  v.quantisation_limit = quantisation_stiffness_limit(axis);
  v.passive = stiffness < v.passive_limit;
  v.free_of_limit_cycles = stiffness <= v.quantisation_limit;
  v.accepted = std::isfinite(stiffness) && std::isfinite(damping) && stiffness >= 0 && damping >= 0 &&
               stiffness <= v.stiffness_allowed && damping <= v.damping_limit;
  return v;
}

// With a fine encoder a tenth of the damper's limit is enough: the stiffness grows with the damping up to there. 2 %
// below the allowed stiffness, so that the figures may be rounded.
Gains suggest(const AxisLimits& axis, double quiet) noexcept {
  const double most = 0.1 * damping_limit(axis);
  const double damping = std::min(most, damping_of_quantum(axis, quiet));
  return {0.98 * kAllowedStiffnessShare * uncoupled_stiffness_limit(axis, damping), damping};
}

}  // namespace

AxisLimits translation_of(const DeviceProperties& device, double period_s, double late_s) noexcept {
  return {.period_s = period_s,
          .delay_s = device.delay_s + 0.5 * late_s,
          .mass = device.mass_kg,
          .damping = device.damping_Ns_per_m,
          .coulomb_friction = device.coulomb_friction_N,
          .quantum = device.position_quantum_m,
          .lead_s = 0};
}

AxisLimits rotation_of(const DeviceProperties& device, double period_s, double late_s) noexcept {
  return {.period_s = period_s,
          .delay_s = device.delay_s + 0.5 * late_s,
          .mass = device.inertia_kg_m2,
          .damping = device.damping_Nms_per_rad,
          .coulomb_friction = device.coulomb_friction_Nm,
          .quantum = device.rotation_quantum_rad,
          .lead_s = 0};
}

// On the boundary the damping grows with the angle up to the angle where the stiffness is back at 0. Without the
// device's own damping that is at most pi / (2 (t_d/T + 1)): bisection between 0 and 1.2 times that. A lead adds lead_s
// of damping per N/m.
double uncoupled_stiffness_limit(const AxisLimits& axis, double coupling_damping) noexcept {
  if (!(axis.mass > 0) || !(coupling_damping + axis.damping > 0)) return 0;
  double least = 0, most = 1.2 * (0.5 * std::numbers::pi) / (axis.delay_s / axis.period_s + 1);
  const auto damping_at = [&axis](double angle) {
    const Gains gains = on_boundary(axis, angle);
    return gains.damping - axis.lead_s * gains.stiffness;
  };
  if (!(damping_at(most) > coupling_damping)) return 0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (least + most);
    (damping_at(middle) < coupling_damping ? least : most) = middle;
  }
  return std::max(0.0, on_boundary(axis, most).stiffness);
}

double little_damping_limit(const AxisLimits& axis, double coupling_damping) noexcept {
  const double late_s = 0.5 * axis.period_s + axis.delay_s - axis.lead_s;
  return late_s > 0 ? (axis.damping + coupling_damping) / late_s : std::numeric_limits<double>::infinity();
}

double damping_limit(const AxisLimits& axis) noexcept { return 0.5 * axis.mass / axis.period_s; }

double passive_stiffness_limit(const AxisLimits& axis, double coupling_damping) noexcept {
  return 2.0 * (axis.damping - std::abs(coupling_damping)) / axis.period_s;
}

double quantisation_stiffness_limit(const AxisLimits& axis) noexcept {
  const double by_damping = 2.0 * axis.damping / axis.period_s;
  return axis.quantum > 0 ? std::min(by_damping, 2.0 * axis.coulomb_friction / axis.quantum) : by_damping;
}

CouplingVerdict check_coupling(const CouplingGains& gains, const DeviceProperties& device, double period_s,
                               double late_s) noexcept {
  CouplingVerdict verdict;
  verdict.translation =
      judge(translation_of(device, period_s, late_s), gains.stiffness_N_per_m, gains.damping_Ns_per_m, kQuietForce_N);
  verdict.rotation = judge(rotation_of(device, period_s, late_s), gains.stiffness_Nm_per_rad, gains.damping_Nms_per_rad,
                           kQuietTorque_Nm);
  if (!device.has_rotation) verdict.rotation.accepted = true;
  verdict.accepted = verdict.translation.accepted && verdict.rotation.accepted;
  return verdict;
}

CouplingGains suggest_gains(const DeviceProperties& device, double period_s, double late_s) noexcept {
  CouplingGains gains;
  const Gains linear = suggest(translation_of(device, period_s, late_s), kQuietForce_N);
  gains.stiffness_N_per_m = linear.stiffness;
  gains.damping_Ns_per_m = linear.damping;
  if (!device.has_rotation) return gains;
  const Gains angular = suggest(rotation_of(device, period_s, late_s), kQuietTorque_Nm);
  gains.stiffness_Nm_per_rad = angular.stiffness;
  gains.damping_Nms_per_rad = angular.damping;
  return gains;
}

}  // namespace tactus::haptics
