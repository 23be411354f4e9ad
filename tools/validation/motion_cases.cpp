// Hard cases of free bodies: conserved quantities.
#include <algorithm>
#include <cmath>

#include "tools/validation/case_world.h"
#include "tools/validation/cases.h"

namespace tactus::hard_cases {
namespace {

Vec3d spin_in_body(const physics::Body& body) {
  return rotate_inverse(body.motion.pose.rotation, body.motion.velocity.angular);
}

// Complete elliptic integral of the first kind, by the arithmetic-geometric mean.
double elliptic_k(double modulus_squared) {
  double a = 1, g = std::sqrt(1 - modulus_squared);
  for (int i = 0; i < 20; ++i) {
    const double mean = 0.5 * (a + g);
    g = std::sqrt(a * g);
    a = mean;
  }
  return kPi / (2 * a);
}

struct Kept {
  double energy{0}, energy_gain{0}, momentum{0};  // largest relative change
};

// Runs the world and records energy and angular momentum; `each` is called after every step.
template <class F>
Kept run_free(CaseWorld& world, double seconds, F&& each) {
  const double energy = world.world.kinetic_energy();
  const Vec3d momentum = world.world.momentum().torque;
  Kept kept;
  for (int k = world.steps_in(seconds); k > 0; --k) {
    world.step();
    const double change = world.world.kinetic_energy() / energy - 1;
    kept.energy = std::max(kept.energy, std::abs(change));
    kept.energy_gain = std::max(kept.energy_gain, change);
    kept.momentum = std::max(kept.momentum, norm(world.world.momentum().torque - momentum) / norm(momentum));
    each();
  }
  return kept;
}

// Spun about the axis of its middle moment of inertia it tumbles: w_y is an elliptic sine with zeros 2 K / rate apart.
Outcome tumbling_body(const Setting& setting) {
  CaseWorld world(setting);
  world.settings.gravity = {};
  const Vec3d inertia{1e-3, 2e-3, 3e-3};
  auto body = physics::make_dynamic_body(0, physics::Shape::sphere(0.1), 1, 0.5, {});
  body.inertia = inertia;
  body.motion.velocity.angular = {0.02, 50, 0.03};
  world.add(body);
  const double e2 = 2 * world.world.kinetic_energy(), l2 = norm_squared(world.world.momentum().torque);
  double before = spin_in_body(world.body(0)).y, first = -1, last = -1, time = 0;
  int crossings = 0;
  const Kept kept = run_free(world, 60, [&] {
    const double now = spin_in_body(world.body(0)).y;
    if ((before < 0) != (now < 0)) {
      last = time + before / (before - now) * setting.step_s;
      if (crossings++ == 0) first = last;
    }
    before = now;
    time += setting.step_s;
  });
  const double rate = std::sqrt((inertia.z - inertia.y) * (l2 - e2 * inertia.x) / (inertia.x * inertia.y * inertia.z));
  const double modulus_squared =
      (inertia.y - inertia.x) * (e2 * inertia.z - l2) / ((inertia.z - inertia.y) * (l2 - e2 * inertia.x));
  Outcome outcome;
  outcome.at_most("change of energy, share", kept.energy, 1e-6);
  outcome.at_most("change of momentum, share", kept.momentum, 1e-3);
  outcome.relative("time between flips, s", (last - first) / std::max(1, crossings - 1),
                   2 * elliptic_k(modulus_squared) / rate, 0.01);
  world.close(outcome);
  return outcome;
}

Outcome thin_rod(const Setting& setting) {
  CaseWorld world(setting);
  world.settings.gravity = {};
  world.add_box(0, {0.5, 0.01, 0.01}, 1, 0.5, {}, {{}, {20, 200, 5}});
  const Kept kept = run_free(world, 10, [] {});
  Outcome outcome;
  outcome.at_most("gain of energy, share", kept.energy_gain, 1e-3);
  outcome.holds("no faster than at the start", norm(world.velocity(0).angular) < 1.01 * norm(Vec3d{20, 200, 5}));
  world.close(outcome);
  return outcome;
}

// Three bodies that drift and turn for a thousand seconds.
Outcome floating_bodies(const Setting& setting) {
  CaseWorld world(setting);
  world.settings.gravity = {};
  const Vec3d velocity[3] = {{0.01, 0, 0}, {0, 0.02, 0.005}, {-0.01, 0.003, 0}};
  world.add_sphere(0, 0.05, 1, 0.5, {0, 0, 0}, velocity[0]);
  world.add_box(1, {0.05, 0.05, 0.05}, 1, 0.5, {{0, 1, 0}, {}}, {velocity[1], {0.3, 0.1, 0}});
  world.add_sphere(2, 0.03, 0.2, 0.5, {0, -1, 0}, velocity[2]);
  Vec3d start[3];
  for (BodyId id = 0; id < 3; ++id) start[id] = world.position(id);
  const Wrenchd momentum = world.world.momentum();
  const Vec3d spin = scale(world.body(1).inertia, spin_in_body(world.body(1)));
  const int steps = 1'000'000 / (setting.step_s > 5e-3 ? 10 : 1);
  for (int k = 0; k < steps; ++k) world.step();
  double off = 0;
  for (BodyId id = 0; id < 3; ++id)
    off = std::max(off, norm(world.position(id) - start[id] - steps * setting.step_s * velocity[id]));
  const Wrenchd end = world.world.momentum();
  Vec3d turned;  // spin about their own centres; the orbital part is checked by the positions
  for (BodyId id = 0; id < 3; ++id) turned += scale(world.body(id).inertia, spin_in_body(world.body(id)));
  Outcome outcome;
  outcome.at_most("change of momentum, share", norm(end.force - momentum.force) / norm(momentum.force), 1e-12);
  outcome.at_most("change of angular momentum, share", norm(turned - spin) / norm(spin), 1e-12);
  outcome.at_most("off x + v t, m", off, 1e-9);
  world.close(outcome);
  return outcome;
}

}  // namespace

std::vector<HardCase> motion_cases() {
  // Number, name, in steps of 10 ms too, function; why it fails in steps of 1 ms, of 10 ms.
  return {
      {10, "body that tumbles about its middle axis", true, tumbling_body},
      {11, "thin rod at 200 rad/s", true, thin_rod},
      {24, "floating for a thousand seconds", true, floating_bodies},
  };
}

}  // namespace tactus::hard_cases
