// Hard cases of friction: slopes at the threshold, spinning, rolling, self-locking.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rt/base/check.h"
#include "sim/geometry/hull_builder.h"
#include "tools/validation/case_world.h"
#include "tools/validation/cases.h"

namespace tactus::hard_cases {
namespace {

Vec3d downhill(double slope) { return {std::cos(slope), 0, -std::sin(slope)}; }

void add_box_on_slope(CaseWorld& world, const Vec3d& half, double slope, double friction) {
  world.add_ground(kGround, friction, slope);
  const Quatd tilt = quat_from_rotation_vector(Vec3d{0, slope, 0});
  world.add_box(0, half, 0.4, friction, {rotate(tilt, {0, 0, half.z}), tilt});
}

double acceleration_on_slope(CaseWorld& world, double slope, double from_s, double for_s) {
  world.run(from_s);
  const double before = dot(world.velocity(0).linear, downhill(slope));
  world.run(for_s);
  return (dot(world.velocity(0).linear, downhill(slope)) - before) / for_s;
}

// With friction just above the threshold the body stays; just below and well below it accelerates by Coulomb's law.
Outcome slope_threshold(const Setting& setting) {
  const double slope = 0.5, threshold = std::tan(slope);
  Outcome outcome;
  CaseWorld holds(setting);
  add_box_on_slope(holds, {0.05, 0.05, 0.05}, slope, 1.001 * threshold);
  holds.run(1);
  const Vec3d before = holds.position(0);
  holds.run(1);
  outcome.at_most("creep at 1.001 of the threshold, m/s", norm(holds.position(0) - before), 10e-6);
  holds.close(outcome);
  std::uint64_t hash = outcome.hash;
  for (const double share : {0.99, 0.55}) {
    const double friction = share * threshold;
    CaseWorld slides(setting);
    add_box_on_slope(slides, {0.05, 0.05, 0.05}, slope, friction);
    outcome.relative(fmt::format("acceleration at {:g} of the threshold, m/s2", share),
                     acceleration_on_slope(slides, slope, 0.1, 0.3),
                     kGravity * (std::sin(slope) - friction * std::cos(slope)), 0.01);
    slides.close(outcome);
    hash ^= outcome.hash;
  }
  outcome.hash = hash;
  return outcome;
}

// A tall box tips where tan(slope) > breadth / height, for any friction that prevents sliding; a flat one slides.
Outcome tips_or_slides(const Setting& setting) {
  const Vec3d tall{0.02, 0.02, 0.05};  // b/h = 0.4
  Outcome outcome;
  const auto mode = [&](double slope, double friction) {
    CaseWorld world(setting);
    add_box_on_slope(world, tall, slope, friction);
    world.run(1.5);
    const Quatd tilt = quat_from_rotation_vector(Vec3d{0, slope, 0});
    struct Mode {
      double turned, slid;
    } m{norm(small_rotation_vector(world.body(0).motion.pose.rotation * conjugate(tilt))),
        dot(world.position(0), downhill(slope))};
    const std::uint64_t last = outcome.hash;
    world.close(outcome);
    outcome.hash ^= last;
    return m;
  };
  const auto stands = mode(std::atan(0.4 / 1.03), 0.8), tips = mode(std::atan(0.4 * 1.03), 0.8);
  outcome.at_most("turned below the limit, rad", stands.turned, 0.01);
  outcome.at_most("slid below the limit, m", stands.slid, 1e-3);
  outcome.holds("tips above it", tips.turned > 0.5);
  const auto slides = mode(std::atan(0.35), 0.3);
  outcome.at_most("turned while it slides, rad", slides.turned, 0.01);
  outcome.holds("slides", slides.slid > 0.1);
  return outcome;
}

// Four points at the corners, each with a quarter of the load: the moment is mu N rho, rho the half diagonal.
Outcome spinning_box(const Setting& setting) {
  const double half = 0.05, mass = 1, friction = 0.3, spin = 20;
  CaseWorld world(setting);
  world.add_ground(kGround, friction);
  world.add_box(0, {half, half, half}, mass, friction, {{0, 0, half}, {}});
  world.run(0.5);
  world.velocity(0).angular.z = spin;
  double stopped = 0;
  for (int k = world.steps_in(1); k > 0; --k) {
    world.step();
    if (world.velocity(0).angular.z > 0.01) stopped += world.settings.dt;
  }
  const double inertia = world.body(0).inertia.z, moment = friction * mass * kGravity * std::sqrt(2.0) * half;
  Outcome outcome;
  outcome.relative("stopped after, s", stopped, inertia * spin / moment, 0.05);
  outcome.at_most("went to the side, m", std::hypot(world.position(0).x, world.position(0).y), 1e-4);
  world.close(outcome);
  return outcome;
}

Outcome rolling_sphere(const Setting& setting) {
  const double slope = 0.3, radius = 0.05;
  CaseWorld world(setting);
  world.add_ground(kGround, 0.8, slope);
  world.add_sphere(0, radius, 0.3, 0.8, rotate(quat_from_rotation_vector(Vec3d{0, slope, 0}), {0, 0, radius}));
  Outcome outcome;
  outcome.relative("acceleration, m/s2", acceleration_on_slope(world, slope, 0.2, 0.5),
                   5.0 / 7 * kGravity * std::sin(slope), 0.005);
  outcome.relative("speed of its rim, m/s", world.velocity(0).angular.y * radius,
                   dot(world.velocity(0).linear, downhill(slope)), 0.005);
  world.close(outcome);
  return outcome;
}

// --- a wedge of half angle `alpha` in a groove of two planes: weightless, pressed down, let go

struct Wedge {
  double pressed_N, left_N, moved_m;  // normal force on a side while pressed; after release; distance moved back
};

Wedge press_wedge(double alpha, double friction, double force_N, const Setting& setting, Outcome& outcome) {
  // Isosceles: its point down, as deep as its sides are steep.
  const double half = 0.02, height = half / std::tan(alpha);
  std::vector<Vec3d> points;
  for (const double y : {-0.02, 0.02}) {
    points.push_back({0, y, 0.3 * height});  // cut off at the point
    points.back().x = 0.3 * half;
    points.push_back({-0.3 * half, y, 0.3 * height});
    points.push_back({half, y, height});
    points.push_back({-half, y, height});
  }
  const auto built = sim::build_hull(points);
  TACTUS_CHECK(built.ok(), points.size(), 0);
  const sim::BuiltHull& hull = built.value();
  const physics::Hull hulls[] = {hull.hull};
  CaseWorld world(setting, 1000, {}, {hulls, {}, {}});
  world.settings.gravity = {};
  for (int side = 0; side < 2; ++side) {
    const double turn = (side == 0 ? 1 : -1) * (kPi / 2 - alpha);  // the plane's normal from up to the groove's inside
    world.add(physics::make_fixed_body(kGround + static_cast<BodyId>(side), physics::Shape::plane(), friction,
                                       {{}, quat_from_rotation_vector(Vec3d{0, turn, 0})}));
  }
  const double mass = 0.2;
  physics::Body body =
      physics::make_dynamic_body(0, physics::Shape::convex(hulls[0], 0), mass, friction, hull.given_from_body);
  body.inertia = mass * hull.hull.inertia_per_kg;
  world.add(body);
  // Slow enough that the sides slide throughout and friction is at its limit.
  const int ramp = world.steps_in(0.5);
  for (int k = 1; k <= ramp; ++k) {
    world.hold(0, {{0, 0, -force_N * k / ramp}, {}});
    world.step();
  }
  Wedge wedge{};
  wedge.pressed_N = 0.5 * world.carried_by_fixed();
  const double pressed_z = world.position(0).z;
  for (int k = ramp; k >= 0; --k) {
    world.hold(0, {{0, 0, -force_N * k / ramp}, {}});
    world.step();
  }
  world.run(0.5);
  wedge.left_N = 0.5 * world.carried_by_fixed();
  wedge.moved_m = world.position(0).z - pressed_z;
  const std::uint64_t last = outcome.hash;
  world.close(outcome);
  outcome.hash ^= last;
  return wedge;
}

Outcome wedge(const Setting& setting) {
  const double alpha = 0.3, force = 20;
  Outcome outcome;
  const Wedge smooth = press_wedge(alpha, 0.98 * std::tan(alpha), force, setting, outcome);
  const Wedge rough = press_wedge(alpha, 1.02 * std::tan(alpha), force, setting, outcome);
  const double mu = 1.02 * std::tan(alpha);
  outcome.relative("force of a side, N", rough.pressed_N, force / (2 * (std::sin(alpha) + mu * std::cos(alpha))), 0.05);
  outcome.holds("stays locked at 1.02 tan", rough.left_N > 0.5 * rough.pressed_N);
  outcome.at_most("left of the force at 0.98 tan", smooth.left_N / smooth.pressed_N, 0.02);
  return outcome;
}

}  // namespace

std::vector<HardCase> friction_cases() {
  // Number, name, in steps of 10 ms too, function; why it fails in steps of 1 ms, of 10 ms.
  return {
      {7, "slope at the friction threshold", true, slope_threshold},
      {8, "tall box on a slope: tips or slides", true, tips_or_slides},
      {9, "spinning box", true, spinning_box},
      {14, "wedge at its locking angle", true, wedge},
      {28, "sphere rolls down a slope", true, rolling_sphere},
  };
}

}  // namespace tactus::hard_cases
