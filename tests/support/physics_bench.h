// A world that predicts: what a body does by the formulas of mechanics, beside the world that must do it.
// Frame: z up. Units: SI.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "rt/physics/world.h"
#include "tests/support/random.h"

namespace tactus::test {

inline constexpr double kGravity = 9.81;  // m/s^2
inline constexpr double kPi = 3.14159265358979323846;

struct PhysicsBench {
  explicit PhysicsBench(const physics::Capacities& capacities = {}) : world(capacities) {
    settings.gravity = {0.0, 0.0, -kGravity};
  }

  physics::World world;
  physics::StepSettings settings;
  physics::StepReport report;
  physics::CutPredicate cut;

  void step() {
    world.begin_step(settings);
    find_pairs_brute_force(world.bounds(), world.dynamic_pairs());
    report = world.finish_step(settings, cut);
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) step();
  }
  void run_seconds(double seconds) { run(static_cast<int>(std::lround(seconds / settings.dt))); }

  physics::Body& body(BodyId id) { return *world.find(id); }
  Vec3d& position(BodyId id) { return body(id).motion.pose.position; }
  Twistd& velocity(BodyId id) { return body(id).motion.velocity; }
  physics::SlotIndex slot(BodyId id) { return *world.slot_of(id); }
  double h() const { return settings.dt / static_cast<double>(settings.sub_steps); }

  // The ground z = 0, tilted so that downhill is +x.
  void add_ground(BodyId id, double friction, double slope_rad = 0.0) {
    const Quatd tilt = quat_from_rotation_vector(Vec3d{0.0, slope_rad, 0.0});
    world.insert(physics::make_fixed_body(id, physics::Shape::plane(), friction, {{}, tilt}));
  }
  void add_sphere(BodyId id, double radius, double mass, double friction, const Vec3d& at, const Vec3d& velocity = {}) {
    auto made = physics::make_dynamic_body(id, physics::Shape::sphere(radius), mass, friction, {at, {}});
    made.motion.velocity.linear = velocity;
    world.insert(made);
  }
  void add_box(BodyId id, const Vec3d& half, double mass, double friction, const Posed& pose,
               const Twistd& velocity = {}) {
    auto made = physics::make_dynamic_body(id, physics::Shape::box(half), mass, friction, pose);
    made.motion.velocity = velocity;
    world.insert(made);
  }
  // Cubes of side 2 half, each resting on the one below, the lowest on z = 0.
  void add_stack(BodyId first, std::uint32_t count, double half, double mass, double friction) {
    for (std::uint32_t k = 0; k < count; ++k)
      add_box(first + k, {half, half, half}, mass, friction, {{0.0, 0.0, half * (2.0 * k + 1)}, {}});
  }

  // --- expected values, from mechanics
  // Position of a thrown body after n sub-steps of semi-implicit Euler, exactly.
  Vec3d thrown(const Vec3d& x0, const Vec3d& v0, std::uint64_t n) const {
    const double k = static_cast<double>(n), h_s = h();
    return x0 + (k * h_s) * v0 + Vec3d{0, 0, -kGravity * h_s * h_s * k * (k + 1) / 2};
  }
  // Overlap of one contact point of effective mass `mass_kg` under a load.
  double overlap_under(double load_N, double mass_kg) const {
    const double omega = 2 * kPi * settings.contact_hertz;
    return settings.slop + load_N / (mass_kg * omega * omega);
  }
};

// Effective mass of the four corner contacts in parallel under a cube, on the ground or on another such cube.
inline double cube_face_mass(double mass, double half, bool on_ground) {
  const double inertia = mass * (2 * half) * (2 * half) / 6;
  const double inverse = 1 / mass + 2 * half * half / inertia;  // the corner is off the axis by half in both directions
  return 4 / (on_ground ? inverse : 2 * inverse);
}

}  // namespace tactus::test
