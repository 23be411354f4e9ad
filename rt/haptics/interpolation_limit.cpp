#include "rt/haptics/interpolation_limit.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace tactus::haptics {
namespace {

// Number of masses that are tried: the proxy's own, each next one twice the last. Beyond, the limit grows.
constexpr unsigned kMasses = 8;
// Search over the stiffness: from this share of the upper bound, growing by this factor, then bisection.
constexpr double kFirstShare = 0.002, kStep = 1.1;
constexpr unsigned kHalves = 6;
// Squarings of the matrix: enough to detect growth or decay by 1e-6 per cycle.
constexpr unsigned kSquarings = 24;

// State between two cycles. x: position, v: velocity. Queue: forces in the delay line, newest first.
enum : std::uint32_t {
  kDeviceX,
  kDeviceV,
  kSampledX,   // device, sampled in the last tick
  kNotedX,     // device, predicted in the last tick for its end
  kReportedX,  // kNotedX at the last synchronisation
  kProxyX,     // in the global world: in G(n + 1) during cycle n
  kProxyV,
  kFeltX,  // in G(n): where the interpolated proxy ends the cycle
  kQueue
};
constexpr std::uint32_t kMaxStates = kQueue + kMaxDelayTicks + 2;
using State = std::array<double, kMaxStates>;
using Matrix = std::array<State, kMaxStates>;  // by rows

class Loop {
 public:
  Loop(const AxisLimits& axis, const InterpolatedProxy& proxy, double stiffness, double damping) noexcept
      : axis_(axis), proxy_(proxy), stiffness_(stiffness), damping_(damping) {
    const double ticks = std::min(axis.delay_s / axis.period_s, 1.0 * kMaxDelayTicks);
    delay_ticks_ = static_cast<std::uint32_t>(ticks);
    delay_rest_s_ = (ticks - delay_ticks_) * axis.period_s;
    states_ = kQueue + delay_ticks_ + 2;
  }

  bool is_stable() const noexcept;

 private:
  void move_device(double force, double time_s, State& s) const noexcept;
  void synchronise(State& s) const noexcept;
  void run_cycle(State& s) const noexcept;
  Matrix matrix_of_cycle() const noexcept;

  AxisLimits axis_;
  InterpolatedProxy proxy_;
  double stiffness_, damping_;
  std::uint32_t delay_ticks_{0}, states_{0};
  double delay_rest_s_{0};  // fraction of the delay beyond whole ticks
};

// A damped mass under held force, by the trapezoidal rule.
void Loop::move_device(double force, double time_s, State& s) const noexcept {
  const double a = 0.5 * axis_.damping * time_s / axis_.mass;
  const double v = ((1 - a) * s[kDeviceV] + force * time_s / axis_.mass) / (1 + a);
  s[kDeviceX] += 0.5 * time_s * (s[kDeviceV] + v);
  s[kDeviceV] = v;
}

// The report and the global step that follows, without delay: as seen from the haptic side.
void Loop::synchronise(State& s) const noexcept {
  const double cycle_s = proxy_.ratio * axis_.period_s;
  const double h = cycle_s / proxy_.global_sub_steps, gain = h * (damping_ + h * stiffness_);
  const double target = s[kNotedX], speed = (target - s[kReportedX]) / cycle_s;
  s[kReportedX] = target;
  for (std::uint32_t j = 0; j < proxy_.global_sub_steps; ++j) {
    const double error = s[kProxyX] - (target + j * h * speed);
    s[kProxyV] = (proxy_.mass * s[kProxyV] + gain * speed - h * stiffness_ * error) / (proxy_.mass + gain);
    s[kProxyX] += h * s[kProxyV];
  }
}

void Loop::run_cycle(State& s) const noexcept {
  const double from = s[kFeltX], to = s[kProxyX];
  synchronise(s);
  s[kFeltX] = to;
  const double felt_v = (to - from) / (proxy_.ratio * axis_.period_s);
  for (std::uint32_t k = 1; k <= proxy_.ratio; ++k) {
    const double felt = from + (to - from) * k / proxy_.ratio;
    const double moved = s[kDeviceX] - s[kSampledX];
    for (std::uint32_t i = delay_ticks_ + 1; i > 0; --i) s[kQueue + i] = s[kQueue + i - 1];
    s[kQueue] = stiffness_ * (felt - s[kDeviceX]) + damping_ * (felt_v - moved / axis_.period_s);
    s[kNotedX] = s[kDeviceX] + moved;
    s[kSampledX] = s[kDeviceX];
    move_device(s[kQueue + delay_ticks_ + 1], delay_rest_s_, s);
    move_device(s[kQueue + delay_ticks_], axis_.period_s - delay_rest_s_, s);
  }
}

// Matrix of a cycle, with positions relative to the proxy, since nothing fixes the absolute position.
Matrix Loop::matrix_of_cycle() const noexcept {
  Matrix matrix{};
  for (std::uint32_t column = 0; column < states_; ++column) {
    if (column == kProxyX) continue;
    State s{};
    s[column] = 1;
    run_cycle(s);
    const double origin = s[kProxyX];
    for (const auto x : {kDeviceX, kSampledX, kNotedX, kReportedX, kProxyX, kFeltX}) s[x] -= origin;
    for (std::uint32_t row = 0; row < states_; ++row) matrix[row][column] = s[row];
  }
  return matrix;
}

// The powers M^(2^k) go to zero or grow without bound, independent of the states' units.
bool Loop::is_stable() const noexcept {
  Matrix power = matrix_of_cycle();
  for (unsigned k = 0; k < kSquarings; ++k) {
    Matrix square{};
    double norm = 0;
    for (std::uint32_t row = 0; row < states_; ++row) {
      for (std::uint32_t i = 0; i < states_; ++i)
        for (std::uint32_t column = 0; column < states_; ++column)
          square[row][column] += power[row][i] * power[i][column];
      double sum = 0;
      for (std::uint32_t column = 0; column < states_; ++column) sum += std::abs(square[row][column]);
      norm = std::max(norm, sum);
    }
    if (norm < 1) return true;
    if (!(norm < 1e100)) return false;
    power = square;
  }
  return false;
}

bool all_masses_are_stable(const AxisLimits& axis, const InterpolatedProxy& proxy, double stiffness,
                           double damping) noexcept {
  InterpolatedProxy pushes = proxy;
  for (unsigned i = 0; i < kMasses; ++i, pushes.mass *= 2)
    if (!Loop(axis, pushes, stiffness, damping).is_stable()) return false;
  return true;
}

}  // namespace

bool interpolation_is_stable(const AxisLimits& axis, const InterpolatedProxy& proxy, double stiffness,
                             double damping) noexcept {
  return Loop(axis, proxy, stiffness, damping).is_stable();
}

double interpolation_stiffness_limit(const AxisLimits& axis, const InterpolatedProxy& proxy, double damping) noexcept {
  const double most = uncoupled_stiffness_limit(axis, damping);
  if (!(proxy.mass > 0) || !(most > 0) || proxy.ratio == 0 || proxy.global_sub_steps == 0) return 0;
  double stable = 0, tried = kFirstShare * most;
  while (all_masses_are_stable(axis, proxy, tried, damping)) {
    if (tried >= most) return most;
    stable = tried;
    tried = std::min(most, kStep * tried);
  }
  if (stable == 0) return 0;
  for (unsigned i = 0; i < kHalves; ++i) {
    const double between = 0.5 * (stable + tried);
    (all_masses_are_stable(axis, proxy, between, damping) ? stable : tried) = between;
  }
  return stable;
}

}  // namespace tactus::haptics
