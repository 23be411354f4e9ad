#include "rt/haptics/force_limiter.h"

#include <algorithm>
#include <cmath>

namespace tactus::haptics {
namespace {

// A vector as direction times largest component: neither huge nor tiny vectors overflow or underflow.
struct Scaled {
  Vec3d direction;   // components within [-1, 1], one of them +-1
  double length{0};  // of `direction`
  double factor{0};  // v = factor * direction
};

Scaled scaled(const Vec3d& v) noexcept {
  const Vec3d a = abs(v);
  const double factor = std::max({a.x, a.y, a.z});
  if (!(factor > 0)) return {};
  const Vec3d direction{v.x / factor, v.y / factor, v.z / factor};
  return {direction, norm(direction), factor};
}

// Returns `v` unchanged, bit for bit, if it is shorter than `limit`; else scaled to `limit` less a few ulps, never
// longer.
Vec3d clamp_length(const Vec3d& v, double limit, bool& clamped) noexcept {
  constexpr double kInside = 1.0 - 16e-16;  // exceeds the rounding error of these operations and of norm()
  const Scaled s = scaled(v);
  if (s.factor * s.length <= limit * kInside) return v;
  clamped = true;
  return s.direction * (limit * kInside / s.length);
}

double limit_now(const ForceLimiter::PortConfig& config, const ForceLimiter::Port& port) noexcept {
  const double peak2 = config.max * config.max;
  const double continuous2 = std::min(config.continuous * config.continuous, peak2);
  if (!(continuous2 > 0)) return 0;
  const double cool = std::clamp(2.0 * (continuous2 - port.heat) / continuous2, 0.0, 1.0);
  return std::sqrt(continuous2 + (peak2 - continuous2) * cool);
}

// The inputs of a tick that are the same for both ports.
struct Request {
  double fade, fade_ratio;  // fade_ratio: to the last tick's fade if it falls, else 1
  Slew slew;
};

Vec3d limit_port(const ForceLimiter::Config& config, const ForceLimiter::PortConfig& port_config,
                 ForceLimiter::Port& port, const Vec3d& wanted, const Request& request,
                 std::uint32_t& status) noexcept {
  bool saturated = false, slewed = false, rounded = false;
  const Vec3d target = clamp_length(wanted, limit_now(port_config, port), saturated) * request.fade;
  const Vec3d from = port.last * request.fade_ratio;
  const double rate = request.slew == Slew::kSlow ? port_config.slow_slew_per_s : port_config.slew_per_s;
  const Vec3d step = clamp_length(target - from, rate * config.period_s, slewed);
  const Vec3d moved = slewed ? from + step : target;
  const Vec3d out = clamp_length(moved, port_config.max, rounded);
  if (saturated) status |= kForceSaturated;
  if (slewed) status |= kSlewLimited;
  port.heat += (norm_squared(out) - port.heat) * (config.period_s / config.thermal_time_s);
  port.last = out;
  return out;
}

}  // namespace

ForceLimiter::Config ForceLimiter::Config::of(const DeviceProperties& device, double period_s) noexcept {
  Config config;
  config.period_s = period_s;
  config.force = {.max = device.max_force_N,
                  .continuous = device.continuous_force_N,
                  .slew_per_s = 5000.0,
                  .slow_slew_per_s = 200.0};
  const double ratio = device.max_force_N > 0 ? device.max_torque_Nm / device.max_force_N : 0.0;
  config.torque = {.max = device.max_torque_Nm,
                   .continuous = device.continuous_torque_Nm,
                   .slew_per_s = 5000.0 * ratio,
                   .slow_slew_per_s = 200.0 * ratio};
  return config;
}

ForceLimiter::Output ForceLimiter::limit(const Wrenchd& wanted, double fade, Slew slew) noexcept {
  const double now = fade >= 1.0 ? 1.0 : (fade > 0.0 ? fade : 0.0);
  const Request request{.fade = now, .fade_ratio = now < state.last_fade ? now / state.last_fade : 1.0, .slew = slew};
  state.last_fade = now;
  Output out;
  if (!is_finite(wanted)) {
    out.fault = Fault::kOutputNotFinite;
    state.force.last = state.torque.last = {};
    return out;
  }
  out.wrench.force = limit_port(config, config.force, state.force, wanted.force, request, out.status);
  out.wrench.torque = limit_port(config, config.torque, state.torque, wanted.torque, request, out.status);
  return out;
}

double ForceLimiter::force_limit_N() const noexcept { return limit_now(config.force, state.force); }
double ForceLimiter::torque_limit_Nm() const noexcept { return limit_now(config.torque, state.torque); }

}  // namespace tactus::haptics
