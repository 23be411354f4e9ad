#include "rt/haptics/coupling_limits.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactus::haptics {
namespace {

AxisVerdict judge(const AxisLimits& axis, double stiffness, double damping) noexcept {
  AxisVerdict v;
  v.stiffness = stiffness;
  v.damping = damping;
  v.stiffness_limit = uncoupled_stiffness_limit(axis, damping);
  v.stiffness_allowed = kAllowedStiffnessShare * v.stiffness_limit;
  v.margin = stiffness > 0 ? v.stiffness_limit / stiffness : std::numeric_limits<double>::infinity();
  v.damping_limit = damping_limit(axis);
  v.passive_limit = passive_stiffness_limit(axis, damping);
  v.quantisation_limit = quantisation_stiffness_limit(axis);
  v.passive = stiffness < v.passive_limit;
  v.free_of_limit_cycles = stiffness <= v.quantisation_limit;
  v.accepted = std::isfinite(stiffness) && std::isfinite(damping) && stiffness >= 0 && damping >= 0 &&
               stiffness <= v.stiffness_allowed && damping <= v.damping_limit;
  return v;
}

}  // namespace

double uncoupled_stiffness_limit(const AxisLimits& axis, double coupling_damping) noexcept {
  return (axis.damping + coupling_damping) / (0.5 * axis.period_s + axis.delay_s);
}

double damping_limit(const AxisLimits& axis) noexcept { return 0.5 * axis.mass / axis.period_s; }

double passive_stiffness_limit(const AxisLimits& axis, double coupling_damping) noexcept {
  return 2.0 * (axis.damping - std::abs(coupling_damping)) / axis.period_s;
}

double quantisation_stiffness_limit(const AxisLimits& axis) noexcept {
  const double by_damping = 2.0 * axis.damping / axis.period_s;
  return axis.quantum > 0 ? std::min(by_damping, 2.0 * axis.coulomb_friction / axis.quantum) : by_damping;
}

CouplingVerdict check_coupling(const CouplingGains& gains, const DeviceProperties& device, double period_s) noexcept {
  const AxisLimits translation{period_s,
                               device.delay_s,
                               device.mass_kg,
                               device.damping_Ns_per_m,
                               device.coulomb_friction_N,
                               device.position_quantum_m};
  const AxisLimits rotation{period_s,
                            device.delay_s,
                            device.inertia_kg_m2,
                            device.damping_Nms_per_rad,
                            device.coulomb_friction_Nm,
                            device.rotation_quantum_rad};
  CouplingVerdict verdict;
  verdict.translation = judge(translation, gains.stiffness_N_per_m, gains.damping_Ns_per_m);
  verdict.rotation = judge(rotation, gains.stiffness_Nm_per_rad, gains.damping_Nms_per_rad);
  if (!device.has_rotation) verdict.rotation.accepted = true;
  verdict.accepted = verdict.translation.accepted && verdict.rotation.accepted;
  return verdict;
}

}  // namespace tactus::haptics
