// A world for a hard case, with the gates that hold in every step, and what mechanics says of soft contacts.
//
// The energy gate, tick by tick: kinetic and potential energy and that of the device's spring never rise by more than
// the work of the wrenches that the case holds and of the device's target, and what the contacts' springs released in
// that tick. What rises unexplained, less what falls, never comes to more than a thousandth of the largest energy in
// play. Frame: world, z up. Thread: one. Units: SI.
#pragma once

#include "rt/physics/passes.h"
#include "rt/physics/world.h"
#include "tools/validation/hard_case.h"

namespace tactus::hard_cases {

inline constexpr double kGravity = 9.81;  // m/s^2
inline constexpr double kPi = 3.14159265358979323846;

// Of the stiffest contacts that the sub-step resolves, and the relax sweeps that they need. `contact_hertz`: what the
// scene would ask for.
physics::StepSettings settings_of(const Setting& setting, double contact_hertz);

class CaseWorld {
 public:
  explicit CaseWorld(const Setting& setting, double contact_hertz = 1000, const physics::Capacities& capacities = {},
                     physics::Hulls hulls = {}, physics::Meshes meshes = {}, const physics::EffectSetups& effects = {});

  physics::World world;
  physics::StepSettings settings;
  physics::StepReport report;  // of the last pass
  physics::CutPredicate cut;
  bool energy_is_booked{true};  // false: where something acts whose work is not known

  void step();
  void run(double seconds);
  int steps_in(double seconds) const;
  // Held until it is set anew; its work is booked. Zero: none.
  void hold(BodyId id, const Wrenchd& wrench);
  // The gates, and the hash of the state.
  void close(Outcome& outcome) const;

  physics::Body& body(BodyId id) { return world.bodies()[slot(id)]; }
  const physics::Body& body(BodyId id) const { return world.bodies()[slot(id)]; }
  std::uint32_t slot(BodyId id) const { return static_cast<std::uint32_t>(world.slot_of(id)); }
  const Vec3d& position(BodyId id) const { return body(id).motion.pose.position; }
  Twistd& velocity(BodyId id) { return body(id).motion.velocity; }
  double fastest() const;  // m/s, of the centres
  double h() const { return settings.dt / settings.sub_steps; }

  void add(const physics::Body& body);
  void add_ground(BodyId id, double friction, double slope_rad = 0);  // z = 0, downhill is +x
  void add_box(BodyId id, const Vec3d& half, double mass, double friction, const Posed& pose, const Twistd& twist = {});
  void add_sphere(BodyId id, double radius, double mass, double friction, const Vec3d& at, const Vec3d& velocity = {});

  // Of the last pass. N: what the contacts of `id` with fixed bodies carry, or all of them.
  double carried_by_fixed() const;
  double carried_between(BodyId a, BodyId b) const;

  // How deep a load sinks into a soft contact of effective mass `mass`.
  double overlap_under(double load_N, double mass_kg) const;

 private:
  void take_pass(const physics::StepSettings& pass);

  struct Springs {
    double before{0}, after{0};
  };
  Springs springs_J() const;
  double stored_J(double ahead_s);
  double work_of_step_J();
  void book(double gained_J);

  struct Held {
    BodyId id;
    Wrenchd wrench;
  };
  std::vector<Held> held_;
  double pass_s_{0};
  double unexplained_J_{0}, least_J_{0}, gain_J_{0}, largest_J_{0};
  std::uint64_t allocations_{0};
  std::uint32_t lost_{0};
  bool finite_{true};
};

// Effective mass of the four corners in parallel of a box's face on an equal face of a box of `other` kg; 0: fixed.
// `half`: of both, z across the face; a cube by default.
double face_mass(double mass, double other, const Vec3d& half = {1, 1, 1});

// How far a rotation has turned a body's z axis from the world's [rad].
double tilt_of(const Quatd& rotation);

}  // namespace tactus::hard_cases
