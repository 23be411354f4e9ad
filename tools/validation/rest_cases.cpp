// Hard cases of bodies at rest over a long time, and of independence from the distance to the origin.
#include <algorithm>
#include <cmath>

#include "tools/validation/case_world.h"
#include "tools/validation/cases.h"

namespace tactus::hard_cases {
namespace {

// Drift, rotation and force ripple of a body at rest on the ground, over `steps`.
Outcome rests(CaseWorld& world, BodyId id, int steps) {
  world.run(2);
  const Posed start = world.body(id).motion.pose;
  double sum = 0, sum_of_squares = 0;
  const double expected = world.body(id).mass * kGravity;
  for (int k = 0; k < steps; ++k) {
    world.step();
    const double off = world.carried_by_fixed() - expected;
    sum += off;
    sum_of_squares += off * off;
  }
  const Posed& end = world.body(id).motion.pose;
  Outcome outcome;
  outcome.at_most("drift, m", norm(end.position - start.position), 1e-6);
  outcome.at_most("turn, rad", norm(small_rotation_vector(end.rotation * conjugate(start.rotation))), 10e-6);
  const double mean = sum / steps;
  outcome.at_most("ripple of the force, N", std::sqrt(std::max(0.0, sum_of_squares / steps - mean * mean)), 1e-6);
  outcome.relative("force, N", expected + mean, expected, 1e-6);
  world.close(outcome);
  return outcome;
}

// 10^6 ticks, or the same time in steps of 10 ms.
Outcome box_rests(const Vec3d& half, double mass, const Setting& setting) {
  CaseWorld world(setting);
  world.add_ground(kGround, 0.5);
  world.add_box(0, half, mass, 0.5, {{0, 0, half.z}, {}});
  return rests(world, 0, 1'000'000 / (setting.step_s > 5e-3 ? 10 : 1));
}

Outcome box_at_rest(const Setting& setting) { return box_rests({0.05, 0.05, 0.05}, 1, setting); }
Outcome thin_card(const Setting& setting) { return box_rests({0.03175, 0.04445, 0.00015}, 0.002, setting); }
// A strip a hundred times as long as wide: moments of inertia in the ratio 1 to 10,000, which a square card does not
// have.
Outcome strip(const Setting& setting) { return box_rests({0.05, 0.0005, 0.00015}, 0.002, setting); }

Outcome long_thin_box(const Setting& setting) {
  CaseWorld world(setting);
  world.add_ground(kGround, 0.5);
  const Quatd on_edge = quat_from_rotation_vector(Vec3d{0, 0.1, 0}) * quat_from_rotation_vector(Vec3d{0.7, 0, 0});
  world.add_box(0, {1, 0.01, 0.01}, 1, 0.5, {{0, 0, 0.2}, on_edge});
  world.run(3);
  double energy = 0;
  for (int k = world.steps_in(1); k > 0; --k) {
    world.step();
    energy = std::max(energy, world.world.kinetic_energy());
  }
  Outcome outcome;
  outcome.at_most("kinetic energy after 3 s, J", energy, 1e-6);
  world.close(outcome);
  return outcome;
}

// A plate on 500 pins of four points each.
Outcome redundant_contacts(const Setting& setting) {
  const physics::Capacities capacities{
      .bodies = 4, .fixed_bodies = 512, .pairs = 1024, .contacts = 512, .border_contacts = 0};
  CaseWorld world(setting, 1000, capacities);
  const double pitch = 0.02, pin = 0.005, mass = 10;
  for (BodyId k = 0; k < 500; ++k)
    world.add(physics::make_fixed_body(1 + k, physics::Shape::box({pin, pin, pin}), 0.5,
                                       {{pitch * (k % 25 - 12.0), pitch * (k / 25 - 9.5), -pin}, {}}));
  world.add_box(0, {0.26, 0.21, 0.01}, mass, 0.5, {{0, 0, 0.01}, {}});
  world.run(1);
  double most = 0;
  for (const auto& contact : world.world.contacts())
    for (std::uint32_t i = 0; i < contact.count; ++i)
      most = std::max(most, contact.points[i].total_normal_impulse / world.settings.dt);
  Outcome outcome;
  outcome.holds("2000 points", world.report.points == 2000);
  outcome.relative("force of all points, N", world.carried_by_fixed(), mass * kGravity, 1e-3);
  outcome.at_most("largest force of a point, N", most, mass * kGravity);
  world.close(outcome);
  return outcome;
}

// A heap that falls, far from the origin and at it.
Outcome far_from_origin(const Setting& setting) {
  const auto fall = [&](CaseWorld& world, const Vec3d& origin) {
    world.add(physics::make_fixed_body(kGround, physics::Shape::plane(), 0.5, {origin, {}}));
    for (BodyId id = 0; id < 4; ++id)
      world.add_box(id, {0.05, 0.05, 0.05}, 1, 0.5, {origin + Vec3d{0.01 * id, 0, 0.05 + 0.1 * id}, {}});
    world.run(3);
  };
  CaseWorld near(setting), far(setting);
  // The offset is exact in binary, so differences come from the arithmetic and not from the scene.
  const Vec3d origin{1024, -1024, 0};
  fall(near, {});
  fall(far, origin);
  double off = 0;
  for (BodyId id = 0; id < 4; ++id) off = std::max(off, norm(far.position(id) - origin - near.position(id)));
  Outcome outcome;
  outcome.at_most("off the run at the origin, m", off, 1e-9);
  far.close(outcome);
  return outcome;
}

}  // namespace

std::vector<HardCase> rest_cases() {
  // Number, name, in steps of 10 ms too, function; why it fails in steps of 1 ms, of 10 ms.
  return {
      {1, "box at rest for a thousand seconds", true, box_at_rest},
      {12, "long thin box dropped on an edge", true, long_thin_box},
      {19, "card of 0.3 mm at rest", true, thin_card},
      {104, "strip of 0.3 mm at rest, moments of inertia 1 to 10,000", true, strip},
      {21, "plate on 2000 redundant points", true, redundant_contacts},
      {40, "a kilometre from the origin", true, far_from_origin},
  };
}

}  // namespace tactus::hard_cases
