#include "rt/haptics/velocity_estimator.h"

#include <algorithm>
#include <cmath>

namespace tactus::haptics {
namespace {

// Slope per tick of the longest straight window that ends now, along one axis.
double straight_slope(const VelocityEstimator::Axes& axes, const VelocityEstimator::State& state, std::uint32_t window,
                      int axis, double quantum) noexcept {
  const double tolerance = quantum * (1.0 + 1e-6);  // for the rounding errors of the sums
  std::array<double, kMaxVelocityWindow + 1> s{};   // s[i] = x_k - x_(k-i)
  double slope = 0;
  for (std::uint32_t n = 1; n <= window; ++n) {
    s[n] = s[n - 1] + axes.steps[(state.newest + kMaxVelocityWindow - (n - 1)) % kMaxVelocityWindow][axis];
    const double candidate = s[n] / n;
    for (std::uint32_t i = 1; i < n; ++i) {
      if (!(std::abs(s[i] - i * candidate) <= tolerance)) return slope;
    }
    slope = candidate;
  }
  return slope;
}

Vec3d estimate(VelocityEstimator::Axes& axes, const VelocityEstimator& e, const Vec3d& step, double quantum) noexcept {
  const std::uint32_t window = std::min({std::max(1u, e.config.window), kMaxVelocityWindow, e.state.count});
  const double stiction_ticks = std::ceil(e.config.stiction_s / e.config.period_s - 1e-9);
  axes.steps[e.state.newest] = step;
  Vec3d velocity;
  for (int axis = 0; axis < 3; ++axis) {
    std::uint32_t& still = axes.still[static_cast<std::size_t>(axis)];
    axes.since_change[axis] += step[axis];
    if (std::abs(axes.since_change[axis]) >= 0.5 * quantum) {
      axes.since_change[axis] = 0;
      still = 0;
    } else if (still < 0xffffffffu) {
      ++still;
    }
    if (still < stiction_ticks) {
      velocity[axis] = straight_slope(axes, e.state, window, axis, quantum) / e.config.period_s;
    }
  }
  return velocity;
}

// Rotation vector of a turn: twice the arc sine of the vector part, to third order (error below 1e-5 of a 0.3 rad
// turn).
Vec3d rotation_vector(const Quatd& turn) noexcept {
  const Vec3d twice_sine = small_rotation_vector(turn);
  return twice_sine * (1.0 + norm_squared(twice_sine) / 24.0);
}

}  // namespace

VelocityEstimator::Config VelocityEstimator::Config::of(const DeviceProperties& device, double period_s) noexcept {
  Config config;
  config.period_s = period_s;
  config.position_quantum_m = device.position_quantum_m;
  config.rotation_quantum_rad = device.rotation_quantum_rad;
  const double window = std::floor(8.0 * std::sqrt(1e-3 / period_s) + 0.5);
  config.window = static_cast<std::uint32_t>(std::clamp(window, 2.0, static_cast<double>(kMaxVelocityWindow)));
  return config;
}

Twistd VelocityEstimator::update(const Posed& device_from_tool) noexcept {
  const Posed last = state.last;
  state.last = device_from_tool;
  if (state.started == 0) {
    state.started = 1;
    return {};
  }
  state.newest = (state.newest + 1) % kMaxVelocityWindow;
  state.count = std::min(state.count + 1, kMaxVelocityWindow);
  const Vec3d moved = device_from_tool.position - last.position;
  const Vec3d turned = rotation_vector(device_from_tool.rotation * conjugate(last.rotation));
  return {estimate(state.linear, *this, moved, config.position_quantum_m),
          estimate(state.angular, *this, turned, config.rotation_quantum_rad)};
}

}  // namespace tactus::haptics
