#include "rt/haptics/coupling_limits.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "rt/haptics/velocity_estimator.h"

using namespace tactus;
using namespace tactus::haptics;

namespace {

// A device's mass with its damping, on a sampled spring and damper whose force is held for a period and late by
// `delay_ticks`; solved exactly between the samples. True when a push dies out within 20 s.
bool is_stable(const AxisLimits& axis, double stiffness, double damping, int delay_ticks) {
  const double T = axis.period_s, m = axis.mass, b = axis.damping;
  const double decay = b > 0 ? std::exp(-b / m * T) : 1.0;
  double x = 0, v = 0.01, last_x = 0, pipeline[4] = {};
  double early = 0, late = 0;
  const int ticks = static_cast<int>(20.0 / T);
  for (int k = 0; k < ticks; ++k) {
    for (int i = 3; i > 0; --i) pipeline[i] = pipeline[i - 1];
    const double speed = (x - last_x) / T;
    pipeline[0] = -stiffness * (x + axis.lead_s * speed) - damping * speed;
    last_x = x;
    const double f = pipeline[delay_ticks];
    // m dv/dt = f - b v over T, with f constant.
    if (b > 0) {
      const double end = f / b;
      x += end * T + (v - end) * (m / b) * (1 - decay);
      v = end + (v - end) * decay;
    } else {
      x += v * T + 0.5 * f / m * T * T;
      v += f / m * T;
    }
    if (!(std::abs(x) < 1e6)) return false;
    if (k < ticks / 10) early = std::max(early, std::abs(v));
    if (k >= ticks - ticks / 10) late = std::max(late, std::abs(v));
  }
  return late < early;
}

}  // namespace

TEST_CASE("the default gains on the default device have the margins that the formulas give") {
  const CouplingVerdict verdict = check_coupling({}, {}, 1e-3);
  CHECK(verdict.accepted);
  CHECK(verdict.translation.stiffness_limit == Approx(5.5 / 1.5e-3).epsilon(0.02));  // 3667 N/m, for little damping
  CHECK(verdict.translation.margin == Approx(11.0 / 6.0).epsilon(0.02));
  CHECK(verdict.translation.damping_limit ==
        Approx(0.5 * 1e-3 / 1e-5));  // 0.5 N a quantum and tick, the damper's own is 150
  CHECK(verdict.rotation.stiffness_limit == Approx(0.022 / 1.5e-3).epsilon(0.03));
  CHECK(verdict.rotation.damping_limit == Approx(0.003 * 8e-3 / 1e-4));  // 3 N mm a quantum in 8 ticks
  CHECK_FALSE(verdict.translation.passive);                              // B > b
}

TEST_CASE("the allowed stiffness is stable on a device that is not as described, where the limit itself is not") {
  const DeviceProperties device;
  const CouplingGains gains;
  const AxisVerdict allowed = check_coupling(gains, device, 1e-3).translation;
  const AxisLimits described{.period_s = 1e-3,
                             .delay_s = 1e-3,
                             .mass = device.mass_kg,
                             .damping = device.damping_Ns_per_m,
                             .coulomb_friction = 0,
                             .quantum = 0};
  AxisLimits light = described, heavy = described, undamped = described;
  light.mass *= 0.6;
  heavy.mass *= 1.4;
  undamped.damping = 0;
  for (const AxisLimits& actual : {described, light, heavy, undamped})
    CHECK(is_stable(actual, allowed.stiffness_allowed, gains.damping_Ns_per_m, 1));
  CHECK(is_stable(described, allowed.stiffness_allowed, gains.damping_Ns_per_m, 2));  // force a tick later
  CHECK_FALSE(is_stable(described, allowed.stiffness_limit, gains.damping_Ns_per_m, 2));
  CHECK_FALSE(is_stable(undamped, 0.99 * allowed.stiffness_limit, gains.damping_Ns_per_m, 1));
  CHECK(allowed.stiffness_allowed > 0.5 * allowed.stiffness_limit);  // no more cautious than that
}

TEST_CASE("the uncoupled limit separates the stable from the unstable in a simulated device") {
  const double damping = GENERATE(2.0, 5.0, 20.0, 80.0);
  const double period = GENERATE(1e-3, 0.25e-3);
  const double own_damping = GENERATE(0.0, 0.5);
  const int delay_ticks = GENERATE(0, 1, 3);
  const double lead_ticks = GENERATE(0.0, 0.5, 0.625, 0.75);
  const AxisLimits axis{.period_s = period,
                        .delay_s = delay_ticks * period,
                        .mass = 0.3,
                        .damping = own_damping,
                        .coulomb_friction = 0,
                        .quantum = 0,
                        .lead_s = lead_ticks * period};
  const double limit = uncoupled_stiffness_limit(axis, damping);
  CAPTURE(damping, period, delay_ticks, lead_ticks, limit);
  CHECK(is_stable(axis, 0.98 * limit, damping, delay_ticks));
  CHECK_FALSE(is_stable(axis, 1.02 * limit, damping, delay_ticks));
}

TEST_CASE("the limit is (b + B) / (T / 2 + t_d) for little damping, and less for more") {
  AxisLimits axis{1e-3, 1e-3, 0.3, 0.5, 0, 0};
  for (const double delay_s : {0.0, 0.3e-3, 1e-3, 2.5e-3}) {
    axis.delay_s = delay_s;
    CHECK(uncoupled_stiffness_limit(axis, 0.1) == Approx(little_damping_limit(axis, 0.1)).epsilon(3e-3));
    double last = 1;
    for (const double damping : {1.0, 5.0, 20.0, 60.0, 100.0, 150.0}) {
      const double share = uncoupled_stiffness_limit(axis, damping) / little_damping_limit(axis, damping);
      CHECK(share < last);
      last = share;
    }
  }
}

TEST_CASE("where the damper alone is unstable no stiffness is stable") {
  const AxisLimits axis{1e-3, 1e-3, 0.3, 0, 0, 0};
  const double edge = 2 * (std::sqrt(2.0) - 1) * axis.mass / axis.period_s;
  CHECK(uncoupled_stiffness_limit(axis, 0.999 * edge) > 0);
  CHECK(uncoupled_stiffness_limit(axis, 1.001 * edge) == 0);
  CHECK(uncoupled_stiffness_limit(axis, std::numeric_limits<double>::quiet_NaN()) == 0);
  CHECK(uncoupled_stiffness_limit({1e-3, 1e-3, 0, 0.5, 0, 0}, 5) == 0);
}

TEST_CASE("a tick that wakes late delays the force: fewer gains are accepted") {
  const DeviceProperties device;
  CHECK(check_coupling({}, device, 1e-3).accepted);
  CHECK(check_coupling({}, device, 1e-3, 1e-6).translation.stiffness_limit <
        check_coupling({}, device, 1e-3).translation.stiffness_limit);
  CHECK(check_coupling({}, device, 1e-3, 0.4e-3).translation.stiffness_limit ==
        Approx(5.5 / (0.5e-3 + 1e-3 + 0.2e-3)).epsilon(0.03));  // late by up to 0.4 ms: by half of it in the mean
  CHECK_FALSE(check_coupling({}, device, 1e-3, 0.4e-3).accepted);
}

TEST_CASE("gains that are suggested are accepted, also when rounded, and the damper stays quiet") {
  const double late_s = GENERATE(0.0, 50e-6, 400e-6);
  const double period_s = GENERATE(1e-3, 0.25e-3);
  DeviceProperties device;
  device.delay_s = period_s;
  CouplingGains gains = suggest_gains(device, period_s, late_s);
  const double window = VelocityEstimator::Config::of(device, period_s).window;
  CHECK(gains.damping_Ns_per_m * device.position_quantum_m / (window * period_s) <= 0.0125 * (1 + 1e-12));
  CHECK(check_coupling(gains, device, period_s, late_s).accepted);
  CHECK(check_coupling(gains, device, period_s, late_s).translation.stiffness_allowed < 1.03 * gains.stiffness_N_per_m);
  gains.damping_Ns_per_m *= 0.995;
  gains.stiffness_N_per_m *= 1.005;
  gains.damping_Nms_per_rad *= 0.995;
  gains.stiffness_Nm_per_rad *= 1.005;
  CHECK(check_coupling(gains, device, period_s, late_s).accepted);
  device.position_quantum_m = 0;
  CHECK(check_coupling(suggest_gains(device, period_s, late_s), device, period_s, late_s).accepted);
}

TEST_CASE("the damper limit keeps its margin to the instability of a free mass with one period of delay") {
  const AxisLimits axis{1e-3, 1e-3, 0.3, 0, 0, 0};
  const double edge = 2 * (std::sqrt(2.0) - 1) * axis.mass / axis.period_s;
  CHECK(is_stable(axis, 0, 0.98 * edge, 1));
  CHECK_FALSE(is_stable(axis, 0, 1.02 * edge, 1));
  CHECK(damping_limit(axis) == Approx(edge / (4 * (std::sqrt(2.0) - 1))));
}

TEST_CASE("the certificate is b > K T / 2 + |B|, for either sign of B") {
  const AxisLimits axis{1e-3, 0, 0.3, 0.5, 0, 0};
  CHECK(passive_stiffness_limit(axis, 0) == Approx(1000));
  for (const double B : {0.2, -0.2}) {
    const double K = passive_stiffness_limit(axis, B);
    CHECK(axis.damping == Approx(K * axis.period_s / 2 + std::abs(B)));
  }
  CHECK(passive_stiffness_limit(axis, 0.6) < 0);
}

TEST_CASE("the quantisation limit is the smaller of damping and dry friction, and zero without friction") {
  CHECK(quantisation_stiffness_limit({1e-3, 0, 0.3, 0.5, 0.1, 1e-5}) == Approx(1000));
  CHECK(quantisation_stiffness_limit({1e-3, 0, 0.3, 0.5, 0.002, 1e-5}) == Approx(400));
  CHECK(quantisation_stiffness_limit({1e-3, 0, 0.3, 0.5, 0, 1e-5}) == 0);
  CHECK(quantisation_stiffness_limit({1e-3, 0, 0.3, 0.5, 0, 0}) == Approx(1000));
}

TEST_CASE("gains are refused above the allowed share, above the damper limit, negative or not a number") {
  const DeviceProperties device;
  CouplingGains gains;
  const double allowed = check_coupling(gains, device, 1e-3).translation.stiffness_allowed;
  gains.stiffness_N_per_m = 0.999 * allowed;
  CHECK(check_coupling(gains, device, 1e-3).accepted);
  gains.stiffness_N_per_m = 1.001 * allowed;
  CHECK_FALSE(check_coupling(gains, device, 1e-3).translation.accepted);
  gains = {};
  gains.damping_Ns_per_m = 50.1;
  CHECK_FALSE(check_coupling(gains, device, 1e-3).translation.accepted);
  for (const double bad : {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    gains = {};
    gains.stiffness_Nm_per_rad = bad;
    CHECK_FALSE(check_coupling(gains, device, 1e-3).accepted);
    gains = {};
    gains.damping_Ns_per_m = bad;
    CHECK_FALSE(check_coupling(gains, device, 1e-3).accepted);
  }
  gains = {0, 5, 0, 0.02};
  CHECK(check_coupling(gains, device, 1e-3).accepted);
  CHECK(std::isinf(check_coupling(gains, device, 1e-3).translation.margin));
}

TEST_CASE("a three-degree-of-freedom device is judged by its translation alone") {
  DeviceProperties device;
  device.has_rotation = false;
  CouplingGains gains;
  gains.stiffness_Nm_per_rad = 1e6;
  CHECK(check_coupling(gains, device, 1e-3).accepted);
}
