#include "rt/haptics/passivity.h"

#include <algorithm>

namespace tactus::haptics {
namespace {

constexpr std::uint32_t kSlots = kMaxFeltLateTicks + 2;

// Access to a port's ring by age (1: sent last tick), and the delay as whole ticks plus a fraction.
struct Flight {
  const Passivity::Port& port;
  std::uint32_t newest, whole;
  double rest;

  Flight(const Passivity::Port& of, std::uint32_t at, double felt_late_ticks) noexcept
      : port(of), newest(at), whole(0), rest(0) {
    const double ticks = std::clamp(felt_late_ticks, 0.0, double{kMaxFeltLateTicks});
    whole = std::min(static_cast<std::uint32_t>(ticks), kMaxFeltLateTicks - 1);
    rest = ticks - whole;
  }
  const Passivity::Sent& aged(std::uint32_t age) const noexcept {
    return port.sent[(newest + kSlots - (age - 1)) % kSlots];
  }
  // The value that the device held over the interval just ended.
  Vec3d felt(Vec3d Passivity::Sent::*what) const noexcept {
    const Vec3d& now = aged(whole + 1).*what;
    return rest > 0 ? (1 - rest) * now + rest * aged(whole + 2).*what : now;
  }
  // Sum of the damping that is sent and not yet felt.
  Vec3d damping_under_way() const noexcept {
    Vec3d sum;
    for (std::uint32_t age = 1; age <= whole; ++age) sum += aged(age).damping;
    if (rest > 0) sum += rest * aged(whole + 1).damping;
    return sum;
  }
  // Spring energy that the hand can still get back: the stored energy at the time of sending of the wrench that it
  // feels next.
  double stored_J() const noexcept {
    const double later = whole > 0 ? aged(whole).stored_J : port.stored_J;
    return rest > 0 ? std::max(later, aged(whole + 1).stored_J) : later;
  }
};

void observe(Passivity::Port& port, const Passivity::PortConfig& config, const Flight& flight, double period_s,
             const Vec3d& velocity) noexcept {
  const double into_virtual_J = -period_s * dot(flight.felt(&Passivity::Sent::wrench), velocity);
  if (into_virtual_J > 0) {
    port.in_J += into_virtual_J;
  } else {
    port.out_J -= into_virtual_J;
  }
  port.dissipated_J -= period_s * dot(flight.felt(&Passivity::Sent::damping), velocity);
  port.energy_J += into_virtual_J;
  const double ceiling_J = config.energy_cap_J + std::max(0.0, flight.stored_J());
  if (port.energy_J > ceiling_J) {
    port.dropped_J += port.energy_J - ceiling_J;
    port.energy_J = ceiling_J;
  } else if (port.energy_J < -config.debt_cap_J) {
    port.forgiven_J += -config.debt_cap_J - port.energy_J;
    port.energy_J = -config.debt_cap_J;
  }
}

// Damping force on the hand for this tick; zero, and alpha zero, without an energy debt.
Vec3d due_damping(Passivity::Port& port, const Passivity::PortConfig& config, const Flight& flight, double period_s,
                  const Vec3d& velocity) noexcept {
  const double speed_squared = norm_squared(velocity);
  const double owed_J = period_s * dot(flight.damping_under_way(), velocity) - port.energy_J;
  port.alpha = 0;
  if (owed_J > 0 && speed_squared > config.min_speed * config.min_speed)
    port.alpha = std::min(config.max_damping, owed_J / (period_s * speed_squared));
  return velocity * -port.alpha;
}

Vec3d control_port(Passivity::Port& port, const Passivity::PortConfig& port_config, const Passivity::Config& config,
                   std::uint32_t newest, const Vec3d& wanted, const Vec3d& velocity) noexcept {
  const Flight flight(port, newest, config.felt_late_ticks);
  observe(port, port_config, flight, config.period_s, velocity);
  port.damping = due_damping(port, port_config, flight, config.period_s, velocity);
  return port.alpha > 0 ? wanted + port.damping : wanted;  // unchanged, including the sign of a zero
}

}  // namespace

Passivity::Config Passivity::Config::of(const DeviceProperties& device, const CouplingGains& gains,
                                        double period_s) noexcept {
  Config config;
  config.period_s = period_s;
  config.felt_late_ticks = device.delay_s / period_s;
  config.translation.max_damping = device.damping_Ns_per_m + gains.damping_Ns_per_m;
  config.rotation.max_damping = device.damping_Nms_per_rad + gains.damping_Nms_per_rad;
  // A tenth of a quantum per period: a speed that the device cannot distinguish from rest over the velocity window.
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
  state.translation.stored_J = stored.translation_J;
  state.rotation.stored_J = stored.rotation_J;
  return {control_port(state.translation, config.translation, config, state.newest, wanted.force, tool_velocity.linear),
          control_port(state.rotation, config.rotation, config, state.newest, wanted.torque, tool_velocity.angular)};
}

void Passivity::record_sent(const Wrenchd& sent) noexcept {
  state.newest = (state.newest + 1) % kSlots;
  const auto put = [this](Port& port, const Vec3d& wrench) {
    const bool none = norm_squared(wrench) == 0;  // disarmed: no damping is in transit either
    port.sent[state.newest] = {wrench, none ? Vec3d{} : port.damping, port.stored_J};
  };
  put(state.translation, sent.force);
  put(state.rotation, sent.torque);
}

}  // namespace tactus::haptics
