// Hard cases of the effects: restitution, joints, torsional friction.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "tools/validation/case_world.h"
#include "tools/validation/cases.h"

namespace tactus::hard_cases {
namespace {

using physics::EffectSetups;
using physics::Joint;
using physics::JointKind;

template <class EffectType>
EffectSetups with(const typename EffectType::Setup& setup) {
  EffectSetups setups;
  std::get<typename EffectType::Setup>(setups) = setup;
  return setups;
}

// Combines the hashes of several worlds.
void close_with(const CaseWorld& world, Outcome& outcome) {
  const std::uint64_t last = outcome.hash;
  world.close(outcome);
  outcome.hash ^= last;
}

// Equal and unequal balls. Momentum and Newton's law give both velocities.
Outcome head_on(const Setting& setting) {
  Outcome outcome;
  for (const double e : {1.0, 0.5})
    for (const double ratio : {1.0, 3.0}) {
      const std::array<double, 2> by_id{e, e};
      CaseWorld world(setting, 1000, {}, {}, with<physics::Restitution>({by_id}));
      world.settings.gravity = {};
      const double v0 = 1, v1 = -0.6, m0 = 0.2 * ratio, m1 = 0.2;
      world.add_sphere(0, 0.05, m0, 0.5, {-0.2, 0, 0}, {v0, 0, 0});
      world.add_sphere(1, 0.05, m1, 0.5, {0.2, 0, 0}, {v1, 0, 0});
      world.run(0.5);
      const double common = (m0 * v0 + m1 * v1) / (m0 + m1), apart = e * (v0 - v1);
      outcome.relative("first ball, m/s", world.velocity(0).linear.x, common - apart * m1 / (m0 + m1), 1e-6);
      outcome.relative("second ball, m/s", world.velocity(1).linear.x, common + apart * m0 / (m0 + m1), 1e-6);
      close_with(world, outcome);
    }
  return outcome;
}

Outcome bouncing_ball(const Setting& setting) {
  const double e = 0.8, radius = 0.05, height = 1;
  const std::array<double, 1> by_id{e};
  CaseWorld world(setting, 1000, {}, {}, with<physics::Restitution>({by_id}));
  world.add_ground(kGround, 0.5);
  world.add_sphere(0, radius, 0.2, 0.5, {0, 0, radius + height});
  Outcome outcome;
  double top = 0, expected = height, before = -1;
  for (int k = world.steps_in(5); k > 0 && outcome.metrics.size() < 5; --k) {
    world.step();
    const double v = world.velocity(0).linear.z;
    top = std::max(v > 0 ? world.position(0).z - radius : 0.0, top);
    if (before > 0 && v <= 0) {
      expected *= e * e;
      // The highest position in a step is below the exact top.
      top = std::max(top, world.position(0).z - radius);
      outcome.relative("height, m", top, expected, 0.02);
      top = 0;
    }
    before = v;
  }
  outcome.holds("bounces five times", outcome.metrics.size() == 5);
  world.close(outcome);
  return outcome;
}

// Five balls on rods that touch; the first is let go from 0.5 rad. The velocities after the impact depend on the model
// of simultaneous contacts and are only recorded; the energy is checked.
Outcome newtons_cradle(const Setting& setting) {
  const double radius = 0.02, mass = 0.1, length = 0.3, angle = 0.5;
  const std::array<double, 5> by_id{1, 1, 1, 1, 1};
  std::array<Joint, 5> rods;
  for (BodyId id = 0; id < 5; ++id) {
    rods[id].kind = JointKind::kDistance;
    rods[id].b = id;
    rods[id].a_from_joint.position = {2 * radius * id, 0, length};
    rods[id].limited = true;
    rods[id].low = rods[id].high = length;
  }
  EffectSetups setups = with<physics::Restitution>({by_id});
  std::get<physics::Joints::Setup>(setups) = {rods};
  CaseWorld world(setting, 1000, {}, {}, setups);
  for (BodyId id = 0; id < 5; ++id) {
    const double a = id == 0 ? angle : 0;
    world.add_sphere(id, radius, mass, 0, {2 * radius * id - length * std::sin(a), 0, length * (1 - std::cos(a))});
  }
  const auto energy = [&] {
    return world.world.kinetic_energy() + world.world.potential_energy(world.settings.gravity);
  };
  const double start = energy();
  // At the turning points, where all balls are at rest, the energy is exact; between them it varies with the
  // integrator's error. The fall takes a quarter of 1.1 s, so impacts occur at 0.28, 0.83 and 1.38 s, with turning
  // points between.
  double off = 0, last_J = 0, last_kinetic_J = 0, before_J = 0;
  std::array<double, 5> after{};
  int turns = 0;
  for (int k = 0; k < world.steps_in(1.5); ++k) {
    world.step();
    const double kinetic_J = world.world.kinetic_energy();
    if (last_kinetic_J < before_J && last_kinetic_J <= kinetic_J && last_kinetic_J < 0.01 * start) {
      ++turns;
      off = std::max(off, std::abs(last_J - start));
    }
    before_J = last_kinetic_J;
    last_kinetic_J = kinetic_J;
    last_J = energy();
    if (k == world.steps_in(0.35))
      for (BodyId id = 0; id < 5; ++id) after[id] = world.velocity(id).linear.x;
  }
  Outcome outcome;
  outcome.holds("two turns", turns == 2);
  outcome.at_most("change of energy, share of the first ball's", off / start, 1e-3);
  for (BodyId id = 0; id < 5; ++id)
    outcome.at_most("recorded: speed after the first impact, m/s", after[id], std::numeric_limits<double>::max());
  world.close(outcome);
  return outcome;
}

// A heavy top with a horizontal axis precesses steadily at exactly m g r / (I3 w).
Outcome heavy_top(const Setting& setting) {
  const double mass = 0.2, arm = 0.05, spin = 100;
  const Vec3d inertia{3e-4, 3e-4, 4e-4};
  const double precession = mass * kGravity * arm / (inertia.z * spin);
  Joint pivot;
  pivot.kind = JointKind::kBall;
  pivot.b = 0;
  pivot.b_from_joint.position = {0, 0, -arm};
  const std::array<Joint, 1> joints{pivot};
  CaseWorld world(setting, 1000, {}, {}, with<physics::Joints>({joints}));
  auto top = physics::make_dynamic_body(0, physics::Shape::sphere(0.02), mass, 0.5,
                                        {{arm, 0, 0}, quat_from_rotation_vector(Vec3d{0, 0.5 * kPi, 0})});
  top.inertia = inertia;
  top.motion.velocity = {{0, precession * arm, 0}, {spin, 0, precession}};
  world.add(top);
  double turned = 0, last = 0, lowest = 0;
  const double seconds = 4;
  for (int k = world.steps_in(seconds); k > 0; --k) {
    world.step();
    const Vec3d& at = world.position(0);
    const double now = std::atan2(at.y, at.x);
    turned += std::remainder(now - last, 2 * kPi);
    last = now;
    lowest = std::min(lowest, at.z);
  }
  Outcome outcome;
  outcome.relative("goes round at, rad/s", turned / seconds, precession, 0.02);
  outcome.at_most("comes down by, share of its arm", -lowest / arm, 0.02);
  world.close(outcome);
  return outcome;
}

// A ball with a circular contact area of uniform pressure: the moment is 2/3 mu N R.
Outcome spinning_disk(const Setting& setting) {
  const double radius = 0.05, patch = 0.02, mass = 1, friction = 0.3, spin = 20;
  const std::array<physics::ContactPatch, 1> by_id{{{patch, 0}}};
  CaseWorld world(setting, 1000, {}, {}, with<physics::ContactTorque>({by_id}));
  world.add_ground(kGround, friction);
  world.add_sphere(0, radius, mass, friction, {0, 0, radius});
  world.run(0.5);
  world.velocity(0).angular.z = spin;
  const double moment = 2.0 / 3 * friction * mass * kGravity * patch;
  const double expected = world.body(0).inertia.z * spin / moment;
  double stopped = 0;
  for (int k = world.steps_in(2 * expected); k > 0; --k) {
    world.step();
    if (world.velocity(0).angular.z > 0.01) stopped += world.settings.dt;
  }
  Outcome outcome;
  outcome.relative("stopped after, s", stopped, expected, 0.03);
  outcome.at_most("went to the side, m", std::hypot(world.position(0).x, world.position(0).y), 1e-4);
  world.close(outcome);
  return outcome;
}

}  // namespace

std::vector<HardCase> effect_cases() {
  // Number, name, in steps of 10 ms too, function; why it fails in steps of 1 ms, of 10 ms.
  return {
      {25, "two balls meet, e = 1 and e = 0.5", true, head_on},
      {26, "bouncing ball, e = 0.8", true, bouncing_ball},
      {27, "Newton's cradle", true, newtons_cradle},
      {29, "heavy top", true, heavy_top},
      {109, "spinning disc, uniform pressure", true, spinning_disk},
  };
}

}  // namespace tactus::hard_cases
