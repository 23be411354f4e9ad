// The interpolation coupling's stiffness limit against the worlds themselves: a device's mass without a hand, the real
// sub-world, the real global world.
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "rt/haptics/coupling/sub_world.h"
#include "rt/haptics/interpolation_limit.h"
#include "sim/global_world.h"

namespace {

using namespace tactus;
using haptics::AxisLimits;
using haptics::CouplingScheme;
using haptics::InterpolatedProxy;

constexpr double kTick_s = 1e-3;
constexpr unsigned kDelayTicks = 1;

AxisLimits device() { return {kTick_s, kDelayTicks * kTick_s, 0.3, 0.5}; }

// A push of the device by 1 mm. True when it dies out: the proxy floats, and nobody holds the device.
bool dies_out(double proxy_kg, unsigned ratio, double stiffness, double damping) {
  sim::Scene scene;
  scene.bodies.push_back(physics::make_dynamic_body(0, physics::Shape::sphere(0.01), proxy_kg, 0.5, {{0, 0, 0}, {}}));
  scene.proxy = 0;
  sim::GlobalOptions options;
  options.coupling = CouplingScheme::kInterpolation;
  options.gains = {stiffness, damping, 1, 0.01};
  options.reach.ratio = ratio;
  options.reach.tick_period_s = kTick_s;
  sim::GlobalWorld global(scene, options);
  haptics::SubWorldConfig config;
  config.scheme = CouplingScheme::kInterpolation;
  config.ratio = ratio;
  config.step.dt = kTick_s;
  config.gains.stiffness_N_per_m = stiffness;
  config.gains.damping_Ns_per_m = damping;
  config.capacities = {.bodies = 1, .fixed_bodies = 1, .pairs = 1, .contacts = 1, .border_contacts = 1};
  haptics::SubWorld sub_world(config, {});
  const auto snapshot = std::make_unique<haptics::WorldSnapshot>();
  const auto report = std::make_unique<haptics::SubWorldReport>();
  global.first_snapshot(*snapshot);

  const AxisLimits axis = device();
  const double decay = std::exp(-axis.damping / axis.mass * kTick_s);
  double x = 1e-3, v = 0, before = x, force[kDelayTicks + 1] = {};
  double early = 0, late = 0;
  const unsigned cycles = 24000 / ratio;
  for (unsigned cycle = 0; cycle < cycles; ++cycle) {
    sub_world.synchronise(*snapshot, *report);
    global.step(*report, *snapshot);
    for (unsigned k = 0; k < ratio; ++k) {
      const haptics::DeviceTarget target{true, {{x, 0, 0}, {}}, {{(x - before) / kTick_s, 0, 0}, {}}};
      before = x;
      for (unsigned i = kDelayTicks; i > 0; --i) force[i] = force[i - 1];
      force[0] = sub_world.step(target, 1, {}).on_device.force.x;
      const double end = force[kDelayTicks] / axis.damping;
      x += end * kTick_s + (v - end) * (axis.mass / axis.damping) * (1 - decay);
      v = end + (v - end) * decay;
      if (!(std::abs(v) < 0.5)) return false;  // from 1 mm: it has grown
      if (cycle < cycles / 8) early = std::max(early, std::abs(v));
      if (cycle >= cycles - cycles / 8) late = std::max(late, std::abs(v));
    }
  }
  return late < 0.1 * early;
}

// By halves: up to where the matrix of a cycle is stable with just this mass.
double boundary(const InterpolatedProxy& proxy, double damping) {
  double stable = 1, unstable = 1;
  while (haptics::interpolation_is_stable(device(), proxy, unstable, damping)) {
    stable = unstable;
    unstable *= 1.1;
  }
  for (int i = 0; i < 20; ++i) {
    const double between = 0.5 * (stable + unstable);
    (haptics::interpolation_is_stable(device(), proxy, between, damping) ? stable : unstable) = between;
  }
  return stable;
}

}  // namespace

TEST_CASE("Interpolation's boundary separates what dies out from what grows, in the two worlds themselves") {
  const unsigned ratio = GENERATE(4u, 10u, 16u);
  const double proxy_kg = GENERATE(0.1, 0.4);
  const double damping = GENERATE(2.0, 5.0);
  const double limit = boundary({proxy_kg, ratio, ratio}, damping);
  CAPTURE(ratio, proxy_kg, damping, limit);
  CHECK(dies_out(proxy_kg, ratio, 0.97 * limit, damping));
  CHECK_FALSE(dies_out(proxy_kg, ratio, 1.03 * limit, damping));
}

TEST_CASE("Below interpolation's limit every proxy dies out that pushes its own mass or more, above it one grows") {
  const unsigned ratio = GENERATE(2u, 8u, 10u, 20u);
  const double damping = 5, proxy_kg = 0.1;
  const double limit = haptics::interpolation_stiffness_limit(device(), {proxy_kg, ratio, ratio}, damping);
  CAPTURE(ratio, limit);
  bool grows = false;
  for (const double mass : {0.1, 0.15, 0.2, 0.3, 0.4, 0.8, 3.2}) {
    CAPTURE(mass);
    CHECK(dies_out(mass, ratio, 0.9 * limit, damping));
    grows = grows || !dies_out(mass, ratio, 1.1 * limit, damping);
  }
  CHECK((grows || limit == haptics::uncoupled_stiffness_limit(device(), damping)));
}

TEST_CASE(
    "Interpolation's limit falls with the ratio, is never above the device's own, and never below the delay's law") {
  for (const double damping : {1.0, 5.0, 20.0}) {
    const double own = haptics::uncoupled_stiffness_limit(device(), damping);
    double last = own * (1 + 1e-9);
    for (const unsigned ratio : {1u, 2u, 4u, 8u, 16u, 32u}) {
      const double limit = haptics::interpolation_stiffness_limit(device(), {0.1, ratio, ratio}, damping);
      CAPTURE(damping, ratio, limit);
      CHECK(limit > 0);
      CHECK(limit <= last);
      AxisLimits delayed = device();
      delayed.delay_s += ratio * kTick_s;
      CHECK(limit >= std::min(own, haptics::little_damping_limit(delayed, damping)));
      last = limit;
    }
  }
}

TEST_CASE(
    "Interpolation's limit with what cannot be: no mass, damping that is too much alone, a delay beyond all bounds") {
  CHECK(haptics::interpolation_stiffness_limit(device(), {0, 10, 10}, 5) == 0);
  CHECK(haptics::interpolation_stiffness_limit(device(), {0.1, 0, 10}, 5) == 0);
  CHECK(haptics::interpolation_stiffness_limit(device(), {0.1, 10, 10}, 1e4) == 0);
  AxisLimits late = device();
  late.delay_s = 2 * haptics::kMaxDelayTicks * kTick_s;
  const double limit = haptics::interpolation_stiffness_limit(late, {0.1, 10, 10}, 1);
  CHECK(limit >= 0);
  CHECK(limit <= haptics::uncoupled_stiffness_limit(late, 1));
}
