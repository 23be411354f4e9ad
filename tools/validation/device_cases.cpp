// Several devices on one global world, each with its own sub-world, in lockstep: two rigid hands, no clock, no link.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "rt/base/check.h"
#include "rt/base/hash.h"
#include "rt/loop/haptic_loop.h"
#include "sim/global_world.h"
#include "tools/session/session.h"
#include "tools/validation/case_scene.h"
#include "tools/validation/case_world.h"
#include "tools/validation/cases.h"

namespace tactus::hard_cases {
namespace {

constexpr double kStart_m = 0.065;  // distance of each proxy's centre from the cube's; contact at 0.06

constexpr double kStiffness = 2000;  // N/m, as in the scene

constexpr const char* kScene = R"(
title = "Two devices squeeze one body"
effects = ["friction", "gyroscopic"]
[simulation]
ratio = 8
members = 4
[coupling]
stiffness_N_per_m = 2000
damping_Ns_per_m = 5
stiffness_Nm_per_rad = 4
damping_Nms_per_rad = 0.02
[device]
position_m = [-0.065, 0, 0]
[proxy]
shape = "sphere"
radius_m = 0.01
mass_kg = 0.2
friction = 0.5
position_m = [-0.065, 0, 0]
[[body]]
shape = "sphere"
radius_m = 0.01
mass_kg = 0.2
friction = 0.5
position_m = [0.065, 0, 0]
[[body]]
shape = "box"
size_m = [0.1, 0.1, 0.1]
mass_kg = 1
friction = 0.5
position_m = [0, 0, 0]
)";

BodyId body_at(const sim::Scene& scene, const Vec3d& position) {
  const auto at = std::find_if(scene.bodies.begin(), scene.bodies.end(),
                               [&](const auto& body) { return norm(body.motion.pose.position - position) < 1e-9; });
  TACTUS_CHECK(at != scene.bodies.end(), scene.bodies.size(), 0);
  return at->id;
}

// A device of prescribed position, and its loop.
struct Hand {
  std::unique_ptr<loop::HapticLoop> loop;
  std::unique_ptr<haptics::WorldSnapshot> snapshot = std::make_unique<haptics::WorldSnapshot>();
  std::unique_ptr<haptics::SubWorldReport> report = std::make_unique<haptics::SubWorldReport>();
  loop::TickInput in;
  loop::TickOutput out;

  // `x`: position of the tool [m], world. The device's origin is the proxy's initial position.
  void tick(double x, bool adopts) {
    auto& sample = in.device.sample;
    in.device.status = haptics::ReadStatus::kFresh;
    ++sample.sequence;
    sample.device_time_ns += 1'000'000;
    sample.device_from_tool.position = {x - loop->config().placement.world_from_device.position.x, 0, 0};
    in.operator_bits = sample.sequence == 1 ? loop::kArm : 0u;
    in.sub_steps = loop->config().sub_world.step.sub_steps;
    in.snapshot = adopts ? snapshot.get() : nullptr;
    in.sink.report = report.get();
    loop->tick(in, out);
    sample.state = out.command.wanted;
  }
  double force() const { return out.command.wrench.force.x; }
};

// Two proxies press a floating cube between them, the right one moving 1.5 times as far, and then carry it along.
Outcome squeeze(const Setting& setting) {
  const sim::Scene scene = case_scene(kScene, setting, 1000);
  session::RunOptions options;
  const haptics::DeviceProperties device;
  sim::GlobalOptions global_options = session::global_options(scene, options, device);
  const BodyId other = body_at(scene, {kStart_m, 0, 0}), cube = body_at(scene, {0, 0, 0});
  global_options.more_devices = {{.proxy = other,
                                  .gains = global_options.gains,
                                  .max_speed_m_per_s = global_options.reach.max_speed_m_per_s,
                                  .max_angular_speed_rad_per_s = global_options.reach.max_angular_speed_rad_per_s}};
  const Status status = sim::check_global_options(scene, global_options);
  TACTUS_CHECK(status.ok(), 0, 0);
  sim::GlobalWorld world(scene, global_options);

  std::array<Hand, 2> hands;
  for (std::uint32_t d = 0; d < 2; ++d) {
    loop::LoopConfig config = session::loop_config(scene, options, device);
    config.sub_world.proxy = d == 0 ? scene.proxy : other;
    config.placement.world_from_device = {{d == 0 ? -kStart_m : kStart_m, 0, 0}, {}};
    hands[d].loop = std::make_unique<loop::HapticLoop>(config, std::span<const physics::Body>());
    world.first_snapshot(*hands[d].snapshot, d);
    hands[d].in.device.sample.state = haptics::DeviceState::kIdle;
  }

  constexpr int kTicks = 6000, kPressed = 2500, kCarried = 4500, kMeasured = 500;
  constexpr double kCarry_m = 0.02;
  double force[2][2] = {}, most_step = 0, last[2] = {};
  bool finite = true, faulted = false;
  double ripple = 0;
  for (int tick = 0; tick < kTicks; ++tick) {
    const bool adopts = tick % static_cast<int>(scene.ratio) == 0;
    const double press = 0.01 * std::clamp(tick / 500.0, 0.0, 1.0);
    const double carry = kCarry_m * std::clamp((tick - 3000) / 1000.0, 0.0, 1.0);
    hands[0].tick(-kStart_m + press + carry, adopts);
    hands[1].tick(kStart_m - 1.5 * press + carry, adopts);
    if (adopts) {
      for (std::uint32_t d = 0; d < 2; ++d) world.impose(d, *hands[d].report);
      world.advance();
      for (std::uint32_t d = 0; d < 2; ++d)
        world.fill_snapshot(d, hands[d].report->cycle + 1, hands[d].report->member_budget, *hands[d].snapshot);
    }
    for (std::size_t d = 0; d < 2; ++d) {
      finite = finite && is_finite(hands[d].out.command.wrench);
      faulted = faulted || hands[d].out.fault != Fault::kNone;
      most_step = std::max(most_step, std::abs(hands[d].force() - last[d]));
      last[d] = hands[d].force();
      for (std::size_t when = 0; when < 2; ++when) {
        const int from = when == 0 ? kPressed : kCarried + 1000;
        if (tick >= from && tick < from + kMeasured) force[when][d] += hands[d].force() / kMeasured;
      }
    }
    if (tick >= kPressed && tick < kPressed + kMeasured)
      ripple = std::max(ripple, std::abs(hands[0].force() + hands[1].force()));
  }

  Outcome outcome;
  outcome.gate("finite", finite);
  outcome.gate("no fault", !faulted);
  outcome.gate("nothing left out", world.statistics().capacity_bits == 0);
  const auto& body = world.bodies()[cube];
  // Equal springs in series: each carries half of the total compression.
  const double expected = kStiffness * 0.5 * (0.01 + 1.5 * 0.01 - 2 * (kStart_m - 0.06));
  outcome.relative("squeezed with, N", -force[0][0], expected, 0.02);
  outcome.near("sum of the forces over one, pressed", (force[0][0] + force[0][1]) / force[0][0], 0, 0.02);
  outcome.near("sum of the forces over one, carried", (force[1][0] + force[1][1]) / force[1][0], 0, 0.02);
  outcome.at_most("ripple of their sum, N", ripple, 0.02 * expected);
  outcome.near("carried along by, m", body.motion.pose.position.x, kCarry_m - 0.25 * 0.01, 2e-4);
  outcome.at_most("largest step of a force, N", most_step, 5 * (1 + 1e-9));
  Fnv1a hash;
  hash.add(world.state_hash());
  for (const Hand& hand : hands) hash.add(hand.loop->state_hash());
  outcome.hash = hash.value();
  return outcome;
}

}  // namespace

std::vector<HardCase> device_cases() {
  return {{.number = 44, .name = "two devices squeeze one body", .global_step = false, .run = squeeze}};
}

}  // namespace tactus::hard_cases
