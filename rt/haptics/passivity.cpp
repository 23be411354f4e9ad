#include "rt/haptics/passivity.h"

#include <algorithm>

namespace tactus::haptics {
namespace {

void observe(Passivity::Port& port, const Passivity::PortConfig& config, double period_s, const Vec3d& velocity,
             double stored_J) noexcept {
  const double into_virtual_J = -period_s * dot(port.sent, velocity);
  if (into_virtual_J > 0) {
    port.in_J += into_virtual_J;
  } else {
    port.out_J -= into_virtual_J;
  }
  port.dissipated_J -= period_s * dot(port.damping, velocity);
  port.energy_J += into_virtual_J;
  const double ceiling_J = config.energy_cap_J + std::max(0.0, stored_J);
  if (port.energy_J > ceiling_J) {
    port.dropped_J += port.energy_J - ceiling_J;
    port.energy_J = ceiling_J;
  } else if (port.energy_J < -config.debt_cap_J) {
    port.forgiven_J += -config.debt_cap_J - port.energy_J;
    port.energy_J = -config.debt_cap_J;
  }
}

// The damping force that is due on the hand; zero, and alpha zero, when nothing is owed.
Vec3d due_damping(Passivity::Port& port, const Passivity::PortConfig& config, double period_s,
                  const Vec3d& velocity) noexcept {
  const double speed_squared = norm_squared(velocity);
  port.alpha = 0;
  if (port.energy_J < 0 && speed_squared > config.min_speed * config.min_speed) {
    port.alpha = std::min(config.max_damping, -port.energy_J / (period_s * speed_squared));
  }
  return velocity * -port.alpha;
}

Vec3d control_port(Passivity::Port& port, const Passivity::PortConfig& config, double period_s, const Vec3d& wanted,
                   const Vec3d& velocity, double stored_J) noexcept {
  observe(port, config, period_s, velocity, stored_J);
  port.damping = due_damping(port, config, period_s, velocity);
  return port.alpha > 0 ? wanted + port.damping : wanted;  // untouched, also in the sign of a zero
}

}  // namespace

Passivity::Config Passivity::Config::of(const DeviceProperties& device, const CouplingGains& gains,
                                        double period_s) noexcept {
  Config config;
  config.period_s = period_s;
  config.translation.max_damping = device.damping_Ns_per_m + gains.damping_Ns_per_m;
  config.rotation.max_damping = device.damping_Nms_per_rad + gains.damping_Nms_per_rad;
  // A tenth of a quantum per period: slower than the device can tell from rest over the velocity window.
  config.translation.min_speed = 0.1 * device.position_quantum_m / period_s;
  config.rotation.min_speed = 0.1 * device.rotation_quantum_rad / period_s;
  return config;
}

Wrenchd Passivity::control(const Wrenchd& wanted, const Twistd& tool_velocity, const StoredEnergy& stored) noexcept {
  if (!is_finite(wanted) || !is_finite(tool_velocity)) {
    state.translation.alpha = state.rotation.alpha = 0;
    state.translation.damping = state.rotation.damping = {};
    return wanted;
  }
  return {control_port(state.translation, config.translation, config.period_s, wanted.force, tool_velocity.linear,
                       stored.translation_J),
          control_port(state.rotation, config.rotation, config.period_s, wanted.torque, tool_velocity.angular,
                       stored.rotation_J)};
}

void Passivity::book(const Wrenchd& sent) noexcept {
  state.translation.sent = sent.force;
  state.rotation.sent = sent.torque;
}

}  // namespace tactus::haptics
