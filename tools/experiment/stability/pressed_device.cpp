#include "tools/experiment/stability/pressed_device.h"

#include <algorithm>
#include <cmath>

#include "hal/simulated_device.h"
#include "rt/haptics/coupling/sub_world.h"
#include "rt/haptics/velocity_estimator.h"
#include "sim/random.h"
#include "tools/experiment/coupling/scheme.h"

namespace tactus::experiment {
namespace {

constexpr double kMinPart_s = 50e-6;
constexpr unsigned kMaxParts = 10, kMaxDelayParts = 32;
// The finest quantum that represents the workspace in 32-bit counts, so that the damper's force from quantisation is
// far below the tap. With fifty times this quantum, a loop that is stable at 4 kHz keeps vibrating for the whole
// observation.
constexpr double kFineQuantum_m = 2e-10;
constexpr std::uint64_t kJitterSeed = 1;

// The hand: a spring soft enough to act as a constant force; it approaches, holds, and taps.
constexpr double kHand_N_per_m = 10, kPress_N = 5, kTap_N = 1;
constexpr double kPressFrom_s = 0.02, kPressed_s = 0.3, kTap_s = 0.6, kTapped_s = 0.604;
// The amplitude after the tap is measured in two windows, far enough apart to detect a stiffness 5 % from the limit.
constexpr double kEarly_s = 0.62, kWindow_s = 0.25, kLate_s = 1.15, kEnd_s = kLate_s + kWindow_s;

constexpr double kPressedProxyRadius_m = 0.02, kProxy_kg = 0.2;
constexpr BodyId kProxy = 0, kWall = 1;

std::int64_t part_ns(const LoopTiming& timing) {
  return static_cast<std::int64_t>(std::llround(1e9 / timing.rate_Hz / parts_of_tick(timing.rate_Hz)));
}

unsigned delay_parts(const LoopTiming& timing) {
  const long parts = std::lround(timing.delay_ticks * parts_of_tick(timing.rate_Hz));
  return static_cast<unsigned>(std::clamp<long>(parts, 1, kMaxDelayParts));
}

hal::DeviceProfile stage_of(const hal::DeviceDescription& description, const LoopTiming& timing) {
  hal::DeviceDescription stage = description;
  stage.kind = hal::KinematicsKind::kStage;
  stage.workspace_radius_m = 0.3;
  stage.coulomb_friction_N = stage.coulomb_friction_Nm = 0;
  stage.max_speed_m_per_s = 100;  // high, so that an unstable loop is detected by its motion and not by a fault
  stage.peak_force_N = 1000;
  const double counts_per_m = 1 / (timing.quantum_m > 0 ? timing.quantum_m : kFineQuantum_m);
  stage.counts_per_m = {counts_per_m, counts_per_m, counts_per_m, 0, 0, 0};
  stage.counts_per_turn = {0, 0, 0, 65536, 65536, 65536};
  stage.transport_delay_ticks = delay_parts(timing);
  return hal::make_profile(stage);
}

hal::HandModel pressing_hand() {
  hal::HandParameters hand;
  hand.stiffness_N_per_m = kHand_N_per_m;
  hand.damping_Ns_per_m = 0;
  hand.mass_kg = 0;
  const Vec3d pressed{0, 0, -kPress_N / kHand_N_per_m}, tapped{0, 0, -(kPress_N + kTap_N) / kHand_N_per_m};
  const hal::HandWaypoint path[] = {
      {kPressFrom_s, {}, {}}, {kPressed_s, pressed, {}}, {kTap_s, pressed, {}}, {kTapped_s, tapped, {}}};
  return {hand, path};
}

// A ball at the tool's position that just touches the wall below.
haptics::SubWorld wall_under_proxy(const LoopTiming& timing, double stiffness, double damping) {
  haptics::SubWorldConfig config;
  config.scheme = kDirectScheme.coupling;
  config.proxy = kProxy;
  config.step.dt = 1 / timing.rate_Hz;
  config.gains.stiffness_N_per_m = stiffness;
  config.gains.damping_Ns_per_m = damping;
  config.capacities = {.bodies = 1, .fixed_bodies = 1, .pairs = 4, .contacts = 4};
  const auto wall = physics::make_fixed_body(kWall, physics::Shape::plane(), 0.5, {});
  haptics::SubWorld world(config, {&wall, 1});
  const auto proxy = physics::make_dynamic_body(kProxy, physics::Shape::sphere(kPressedProxyRadius_m), kProxy_kg, 0.5,
                                                {{0, 0, kPressedProxyRadius_m}, {}});
  world.set_members({&proxy, 1});
  return world;
}

}  // namespace

unsigned parts_of_tick(double rate_Hz) {
  return static_cast<unsigned>(std::clamp(std::floor(1 / (rate_Hz * kMinPart_s) + 1e-9), 1.0, double{kMaxParts}));
}

haptics::DeviceProperties device_in(const hal::DeviceDescription& description, const LoopTiming& timing) {
  haptics::DeviceProperties properties = stage_of(description, timing).properties;
  properties.delay_s = delay_parts(timing) * static_cast<double>(part_ns(timing)) * 1e-9;
  properties.position_quantum_m = timing.quantum_m;
  return properties;
}

bool rings_out(const hal::DeviceDescription& description, const LoopTiming& timing, double stiffness_N_per_m,
               double damping_Ns_per_m) {
  const unsigned parts = parts_of_tick(timing.rate_Hz);
  const auto most_late = static_cast<unsigned>(std::lround(timing.jitter_ticks * parts));
  const hal::DeviceProfile profile = stage_of(description, timing);
  hal::SimulationOptions simulation;
  simulation.period_ns = part_ns(timing);
  simulation.sub_steps = 1;
  hal::SimulatedDevice device(profile, pressing_hand(), simulation);
  haptics::SubWorld world = wall_under_proxy(timing, stiffness_N_per_m, damping_Ns_per_m);
  haptics::VelocityEstimator velocity;
  velocity.config = haptics::VelocityEstimator::Config::of(profile.properties, 1 / timing.rate_Hz);
  sim::Random random(kJitterSeed);

  haptics::DeviceInput input;
  haptics::DeviceCommand command;
  command.wanted = haptics::DeviceState::kForce;
  haptics::DeviceTarget target;
  target.engaged = true;
  const Vec3d place{0, 0, kPressedProxyRadius_m};
  double early = 0, late = 0;
  const auto ticks = static_cast<std::uint64_t>(std::llround(kEnd_s * timing.rate_Hz));
  for (std::uint64_t tick = 0; tick < ticks; ++tick) {
    const auto wakes = static_cast<unsigned>(random.uniform() * (most_late + 1));
    const double time_s = static_cast<double>(tick) / timing.rate_Hz;
    for (unsigned part = 0; part < parts; ++part) {
      device.read(input);
      if (part == wakes) {
        target.pose = {place + input.sample.device_from_tool.position, {}};
        target.velocity = {velocity.update(input.sample.device_from_tool).linear, {}};
        const auto step = world.step(target, world.config().step.sub_steps, {});
        command.wrench = {step.on_device.force, {}};
        // An oscillation that leaves the wall counts as unstable: it stops growing only because the contact is lost.
        if (time_s > kEarly_s && step.on_device.force.z <= 0) return false;
      }
      ++command.sequence;
      device.write(command);
      const double speed = std::abs(device.plant().twist().linear.z);
      if (!(speed < 1e3)) return false;
      if (time_s >= kEarly_s && time_s < kEarly_s + kWindow_s) early = std::max(early, speed);
      if (time_s >= kLate_s) late = std::max(late, speed);
    }
  }
  return late < early;
}

double measured_limit(const hal::DeviceDescription& description, const LoopTiming& timing, double damping_Ns_per_m,
                      double least, double most, double apart) {
  if (!rings_out(description, timing, least, damping_Ns_per_m)) return 0;
  while (most > apart * least) {
    const double middle = std::sqrt(least * most);
    (rings_out(description, timing, middle, damping_Ns_per_m) ? least : most) = middle;
  }
  return std::sqrt(least * most);
}

}  // namespace tactus::experiment
