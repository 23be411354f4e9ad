// Hard cases of the device's spring: at its stability limits, and in narrow gaps.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "rt/base/hash.h"
#include "rt/haptics/coupling_limits.h"
#include "rt/haptics/force_limiter.h"
#include "rt/haptics/passivity.h"
#include "tools/validation/case_world.h"
#include "tools/validation/cases.h"

namespace tactus::hard_cases {
namespace {

constexpr unsigned kMaxDelayTicks = 2;

void couple(CaseWorld& world, BodyId proxy, double stiffness, double damping) {
  auto& spring = world.world.device_spring();
  spring.enabled = true;
  spring.slot = world.slot(proxy);
  spring.stiffness_N_per_m = stiffness;
  spring.damping_Ns_per_m = damping;
  spring.stiffness_Nm_per_rad = 5;
  spring.damping_Nms_per_rad = 0.02;
  spring.target = world.body(proxy).motion.pose;
}

// N, on the device: the mean over the last step.
Vec3d force_on_device(CaseWorld& world) {
  return (-1 / world.settings.dt) * world.world.device_spring().step_impulse.force;
}

// --- a peg in a hole: tilted by a torque to one side, then to the other

constexpr double kPegSide_m = 0.02, kPegLength_m = 0.04, kPegClearance_m = 1e-4;
constexpr double kSlides_m = 1e-3;

// Four walls about the z axis, down from z = `mouth`.
void add_hole(CaseWorld& world, double mouth, double friction) {
  const double in = 0.5 * (kPegSide_m + kPegClearance_m), wall = 0.05;
  for (int k = 0; k < 4; ++k) {
    const double out = (k % 2 == 0 ? 1 : -1) * (in + wall);
    const Vec3d half = k < 2 ? Vec3d{wall, 0.2, wall} : Vec3d{in, wall, wall};
    world.add(physics::make_fixed_body(kGround + static_cast<BodyId>(k), physics::Shape::box(half), friction,
                                       {k < 2 ? Vec3d{out, 0, mouth - wall} : Vec3d{0, out, mouth - wall}, {}}));
  }
}

// Returns how far a peg slides into the hole in a second [m], kSlides_m at most. A moment M first tilts the peg against
// mouth and wall; then a force F presses at the rim of its section. Each contact has the normal force N = M / depth,
// M = F d / 2, and friction carries F while F <= 2 mu N: the peg wedges at depths up to mu d (Whitney 1982, two-point
// contact).
double slides_at_depth(double depth, double friction, const Setting& setting, Outcome& outcome) {
  const double force = 10, moment = 0.5 * kPegSide_m * force;
  CaseWorld world(setting);
  world.settings.gravity = {};
  add_hole(world, 0, friction);
  world.add_box(0, {0.5 * kPegSide_m, 0.5 * kPegSide_m, 0.5 * kPegLength_m}, 0.1, friction,
                {{0, 0, 0.5 * kPegLength_m - depth}, {}});
  world.hold(0, {{}, {0, moment, 0}});
  world.run(0.5);
  const double seated = world.position(0).z;
  const auto slid = [&] { return seated - world.position(0).z; };
  const int ramp = world.steps_in(0.5);
  for (int k = 1; k <= 2 * ramp && slid() < kSlides_m; ++k) {
    world.hold(0, {{0, 0, -force * std::min(1.0, static_cast<double>(k) / ramp)}, {0, moment, 0}});
    world.step();
  }
  world.close(outcome);
  return slid();
}

Outcome peg_in_hole(const Setting& setting) {
  const double side = kPegSide_m, length = kPegLength_m, clearance = kPegClearance_m, torque = 0.1;
  CaseWorld world(setting);
  add_hole(world, 0.05, 0.2);
  world.add(physics::make_fixed_body(kGround + 4, physics::Shape::plane(), 0.2, {{0, 0, -0.5 * length}, {}}));
  world.add_box(0, {0.5 * side, 0.5 * side, 0.5 * length}, 0.1, 0.2, {});
  double tilt = 0, energy = 0, most = 0;
  for (const double way : {1.0, -1.0}) {
    world.hold(0, {{}, {0, way * torque, 0}});
    for (int k = world.steps_in(1); k > 0; --k) {
      world.step();
      energy = std::max(energy, world.world.kinetic_energy());
      for (BodyId id = kGround; id < kGround + 4; ++id) most = std::max(most, world.carried_between(0, id));
    }
    tilt = std::max(tilt, tilt_of(world.body(0).motion.pose.rotation));
  }
  world.hold(0, {});
  world.run(1);
  Outcome outcome;
  const double limit = clearance / length;
  outcome.at_most("tilt, rad", tilt, 1.05 * limit);
  outcome.holds("tilts until it touches", tilt > 0.95 * limit);
  outcome.at_most("largest force of a wall, N", most, haptics::DeviceProperties{}.max_force_N);
  outcome.at_most("kinetic energy, J", energy, torque * 2 * limit);  // the torque's work
  outcome.at_most("speed at the end, m/s", world.fastest(), 1e-4);
  const double rough = 0.5;
  outcome.at_most("slides in at 0.95 of the depth mu d, m",
                  slides_at_depth(0.95 * rough * side, rough, setting, outcome), 1e-5);
  outcome.holds("slides in at 1.05 of the depth mu d",
                slides_at_depth(1.05 * rough * side, rough, setting, outcome) >= kSlides_m);
  world.close(outcome);
  return outcome;
}

// --- the proxy pulled a metre into a corner

Outcome into_a_corner(const Setting& setting) {
  const double radius = 0.01;
  CaseWorld world(setting);
  world.settings.gravity = {};
  const Quatd to_x = quat_from_rotation_vector(Vec3d{0, 0.5 * kPi, 0}),
              to_y = quat_from_rotation_vector(Vec3d{-0.5 * kPi, 0, 0});
  world.add(physics::make_fixed_body(kGround, physics::Shape::plane(), 0.3, {{}, to_x}));
  world.add(physics::make_fixed_body(kGround + 1, physics::Shape::plane(), 0.3, {{}, to_y}));
  world.add_sphere(0, radius, 0.2, 0.3, {2 * radius, 2 * radius, 0});
  couple(world, 0, 2000, 5);
  const haptics::DeviceProperties device;
  haptics::ForceLimiter limiter{haptics::ForceLimiter::Config::of(device, setting.step_s), {}};
  const Vec3d inside = (-1 / std::sqrt(2.0)) * Vec3d{1, 1, 0};
  auto& spring = world.world.device_spring();
  Vec3d sent;
  double deepest = 0, most = 0;
  const int ramp = world.steps_in(1);
  for (int k = 0; k < 2 * ramp; ++k) {
    const double speed = k < ramp ? 1.0 : 0.0;
    spring.target_velocity.linear = speed * inside;
    world.step();
    spring.target.position += (speed * setting.step_s) * inside;
    sent = limiter.limit({force_on_device(world), {}}, 1, haptics::Slew::kNormal).wrench.force;
    most = std::max(most, norm(sent));
    deepest = std::max(deepest, radius - std::min(world.position(0).x, world.position(0).y));
  }
  const double angle = std::acos(std::clamp(-dot(sent, inside) / norm(sent), -1.0, 1.0));
  Outcome outcome;
  outcome.at_most("largest force, N", most, device.max_force_N * (1 + 1e-9));
  outcome.relative("force, N", norm(sent), limiter.force_limit_N(), 1e-3);
  outcome.at_most("off the bisector, rad", angle, 2 * kPi / 180);
  outcome.at_most("deepest overlap, m", deepest, 0.1e-3);
  world.close(outcome);
  return outcome;
}

// --- the proxy between two blocks of 100 kg that are pushed together with 1000 N each

Outcome between_blocks(const Setting& setting) {
  const double radius = 0.02, mass = 0.2, block = 100, force = 1000;
  CaseWorld world(setting);
  world.settings.gravity = {};
  world.add_sphere(0, radius, mass, 0.5, {});
  for (BodyId id = 1; id <= 2; ++id) {
    const double way = id == 1 ? -1 : 1;
    world.add_box(id, {0.1, 0.1, 0.1}, block, 0.5, {{way * (0.1 + radius), 0, 0}, {}});
    world.hold(id, {{-way * force, 0, 0}, {}});
  }
  couple(world, 0, 2000, 5);
  double most = 0;
  for (int k = world.steps_in(2); k > 0; --k) {
    world.step();
    most = std::max(most, norm(force_on_device(world)));
  }
  const double expected = world.overlap_under(force, 1 / (1 / mass + 1 / block));
  Outcome outcome;
  outcome.relative("overlap on the left, m", 0.1 + radius - (world.position(0).x - world.position(1).x), expected,
                   0.05);
  outcome.relative("overlap on the right, m", 0.1 + radius - (world.position(2).x - world.position(0).x), expected,
                   0.05);
  outcome.relative("force between, N", world.carried_between(0, 1), force, 1e-3);
  outcome.at_most("force on the device, N", most, 30);
  world.close(outcome);
  return outcome;
}

// --- the coupling at its limit: a device of 0.3 kg with 0.5 N s/m on a proxy that does not move

// haptics::little_damping_limit is for a loop that holds the sample for the whole tick. The product's loop extrapolates
// the target at the sample's velocity during the tick, so it becomes unstable only at a higher stiffness.
struct DeviceLoop {
  unsigned delay_ticks;  // transport, beyond the sample-and-hold
  bool held;             // the sample, for the whole tick
  double damping_Ns_per_m;
};

// The mean of (j + 1) h over the sub-steps.
double lead_s(const Setting& setting) { return 0.5 * setting.step_s * (1 + 1.0 / sub_steps_of(setting)); }

struct DeviceOnSpring {
  double early_m_per_s{0}, late_m_per_s{0};  // peak speed in the second and the last tenth
  double given_J{0};                         // largest work done on the device
  int active_ticks{0};                       // of the controller
  bool left{false};                          // the workspace of a metre
  bool grows() const { return left || late_m_per_s > early_m_per_s; }
};

DeviceOnSpring push_device(const DeviceLoop& loop, double stiffness, bool controlled, const Setting& setting,
                           Outcome& outcome, double seconds = 5) {
  haptics::DeviceProperties device;
  device.delay_s = loop.delay_ticks * setting.step_s;
  const double T = setting.step_s, m = device.mass_kg, b = device.damping_Ns_per_m, decay = std::exp(-b / m * T);
  CaseWorld world(setting);
  world.settings.gravity = {};
  world.add_sphere(0, 0.1, 1e9, 0.5, {});
  couple(world, 0, stiffness, loop.damping_Ns_per_m);
  haptics::CouplingGains gains;
  gains.stiffness_N_per_m = stiffness;
  gains.damping_Ns_per_m = loop.damping_Ns_per_m;
  haptics::Passivity passivity{haptics::Passivity::Config::of(device, gains, T), {}};
  double x = 0, v = 0.1, last = 0, work = 0;
  std::array<Vec3d, kMaxDelayTicks + 1> sent{};  // newest first
  world.energy_is_checked = false;               // the device's motion is prescribed and does not match its velocity
  DeviceOnSpring result;
  auto& spring = world.world.device_spring();
  const int ticks = world.steps_in(seconds);
  for (int k = 0; k < ticks; ++k) {
    const double speed = (x - last) / T;
    spring.target.position.x = loop.held ? x - lead_s(setting) * speed : x;
    spring.target_velocity.linear.x = speed;
    world.step();
    Wrenchd wanted{force_on_device(world), {}};
    if (controlled) wanted = passivity.control(wanted, spring.target_velocity, {0.5 * stiffness * x * x, 0});
    passivity.record_sent(wanted);
    if (passivity.status() != 0) ++result.active_ticks;
    std::copy_backward(sent.begin(), sent.end() - 1, sent.end());
    sent[0] = wanted.force;
    const double end = sent[loop.delay_ticks].x / b, before = x;
    last = x;
    x += end * T + (v - end) * (m / b) * (1 - decay);
    v = end + (v - end) * decay;
    work += end * b * (x - before);
    result.given_J = std::max(result.given_J, work);
    if (!(std::abs(x) < 1)) {
      x = std::clamp(x, -1.0, 1.0);
      v = 0;
      result.left = true;
    }
    if (k >= ticks / 10 && k < ticks / 5) result.early_m_per_s = std::max(result.early_m_per_s, std::abs(v));
    if (k >= ticks - ticks / 10) result.late_m_per_s = std::max(result.late_m_per_s, std::abs(v));
  }
  const std::uint64_t hash = outcome.hash;
  world.close(outcome);
  Fnv1a all;
  all.add(hash);
  all.add(x);
  all.add(v);
  outcome.hash = all.value();
  return result;
}

// Stiffness at which an oscillation neither grows nor decays, within 1 %, searched between half and twice `near`.
double where_it_rings(const DeviceLoop& loop, double near, const Setting& setting, Outcome& outcome) {
  double least = 0.5 * near, most = 2 * near;
  while (most > 1.01 * least) {
    const double middle = std::sqrt(least * most);
    (push_device(loop, middle, false, setting, outcome).grows() ? most : least) = middle;
  }
  return std::sqrt(least * most);
}

// Beyond the limit the loop oscillates without the passivity controller; with it, the loop supplies at most 0.05 J and
// the oscillation decays.
void hold_beyond(const DeviceLoop& loop, const std::string& what, double stiffness, const Setting& setting,
                 Outcome& outcome) {
  const bool rings = push_device(loop, stiffness, false, setting, outcome).grows();
  const DeviceOnSpring with = push_device(loop, stiffness, true, setting, outcome);
  outcome.at_most("given to the hand at " + what + ", J", with.given_J, 0.05);
  if (!rings) return;
  outcome.holds("the controller acts at " + what, with.active_ticks > 0);
  outcome.holds("it does not grow at " + what, !with.grows() || with.late_m_per_s < 0.05);
}

Outcome coupling_limit(const Setting& setting) {
  const double damping = 5;
  Outcome outcome;
  for (const bool held : {true, false})
    for (unsigned delay_ticks = 0; delay_ticks <= kMaxDelayTicks; ++delay_ticks) {
      const DeviceLoop loop{delay_ticks, held, damping};
      const std::string of = fmt::format("{}, delay {}", held ? "held" : "as it ships", delay_ticks);
      haptics::DeviceProperties device;
      device.delay_s = delay_ticks * setting.step_s;
      haptics::AxisLimits axis = haptics::translation_of(device, setting.step_s);
      const double accepted = haptics::kAllowedStiffnessShare * haptics::uncoupled_stiffness_limit(axis, damping);
      if (!held) axis.lead_s = lead_s(setting);
      const double limit =
          held ? haptics::little_damping_limit(axis, damping) : haptics::uncoupled_stiffness_limit(axis, damping);
      const double rings_at = where_it_rings(loop, limit, setting, outcome);
      outcome.relative("rings from, N/m: " + of, rings_at, limit, 0.15);
      const DeviceOnSpring below = push_device(loop, 0.9 * limit, false, setting, outcome, 10);
      outcome.at_most("speed left at 0.9 of the limit, share: " + of, below.late_m_per_s / 0.1, 0.01);
      hold_beyond(loop, "1.1 of the limit: " + of, 1.1 * limit, setting, outcome);
      for (const double share : {2.0, 2.5})
        hold_beyond(loop, fmt::format("{:g} of what is accepted: {}", share, of), share * accepted, setting, outcome);
    }
  return outcome;
}

}  // namespace

std::vector<HardCase> coupling_cases() {
  // Number, name, in steps of 10 ms too, function; why it fails in steps of 1 ms, of 10 ms, and in what.
  return {
      {13,
       "peg in a hole",
       true,
       peg_in_hole,
       "contacts leave an overlap of 10 um alone at either wall: tilts by 3.08 mrad, 2.63 allowed",
       "same",
       {{"tilt, rad", 3.15e-3}}},
      {16,
       "proxy pulled a metre into a corner",
       false,
       into_a_corner,
       "the proxy of 0.2 kg feels all 2000 N of its spring, the device 30 N: 0.145 mm deep, 0.1 allowed",
       "",
       {{"deepest overlap, m", 1.6e-4}}},
      {23, "proxy between two blocks of 100 kg", true, between_blocks},
      {30, "coupling at 0.9 and 1.1 of its limit", false, coupling_limit},
  };
}

}  // namespace tactus::hard_cases
