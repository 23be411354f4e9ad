// A world for a hard case, with the gates that must hold in every step, and formulas for soft contacts.
//
// The energy gate, tick by tick: the sum of kinetic energy, potential energy and the energy of the device's spring may
// rise only by the work of the held wrenches and of the device's target, plus the energy released by the contact
// springs in that tick. The unexplained rises minus the falls must stay below a thousandth of the largest energy in
// play. Frame: world, z up. Thread: one. Units: SI.
#pragma once

#include "rt/physics/macro_steps.h"
#include "rt/physics/world.h"
#include "tools/validation/hard_case.h"

namespace tactus::hard_cases {

inline constexpr double kGravity = 9.81;  // m/s^2
inline constexpr double kPi = 3.14159265358979323846;
inline constexpr BodyId kGround = 1000;  // and the fixed bodies after it; what moves has lower numbers

// Settings with the stiffest contacts that the sub-step resolves, and the relax sweeps that they need. `contact_hertz`:
// requested by the scene.
physics::StepSettings settings_of(const Setting& setting, double contact_hertz);

class CaseWorld {
 public:
  explicit CaseWorld(const Setting& setting, double contact_hertz = 1000, const physics::Capacities& capacities = {},
                     const physics::ShapeLists& shapes = {}, const physics::EffectSetups& effects = {});

  physics::World world;
  physics::StepSettings settings;
  physics::StepReport report;  // of the last macro step
  physics::CutPredicate cut;
  bool energy_is_checked{true};  // false if something acts whose work is not known

  void step();
  void run(double seconds);
  int steps_in(double seconds) const;
  // Applies `wrench` until the next call; its work is included in the energy account. Zero: none.
  void hold(BodyId id, const Wrenchd& wrench);
  // Enters the gates and the hash of the state.
  void close(Outcome& outcome) const;

  physics::Body& body(BodyId id) { return world.body(slot(id)); }
  const physics::Body& body(BodyId id) const { return world.body(slot(id)); }
  physics::SlotIndex slot(BodyId id) const { return *world.slot_of(id); }
  const Vec3d& position(BodyId id) const { return body(id).motion.pose.position; }
  Twistd& velocity(BodyId id) { return body(id).motion.velocity; }
  double fastest() const;  // m/s, of the centres of mass
  double h() const { return settings.dt / settings.sub_steps; }

  void add(const physics::Body& body);
  void add_ground(BodyId id, double friction, double slope_rad = 0);  // z = 0, downhill is +x
  void add_box(BodyId id, const Vec3d& half, double mass, double friction, const Posed& pose, const Twistd& twist = {});
  void add_sphere(BodyId id, double radius, double mass, double friction, const Vec3d& at, const Vec3d& velocity = {});

  // N, in the last macro step: force of the contacts with fixed bodies, of body `id` or of all bodies.
  double carried_by_fixed() const;
  double carried_between(BodyId a, BodyId b) const;

  // Penetration of a soft contact of effective mass `mass` under a load [m].
  double overlap_under(double load_N, double mass_kg) const;

 private:
  void take_macro_step(const physics::StepSettings& macro_step);

  struct Springs {
    double before{0}, after{0};
  };
  Springs springs_J() const;
  double stored_J(double ahead_s);
  double work_of_step_J();
  void add_to_balance(double gained_J);

  struct Held {
    BodyId id;
    Wrenchd wrench;
  };
  std::vector<Held> held_;
  double macro_step_s_{0};
  double unexplained_J_{0}, least_J_{0}, gain_J_{0}, largest_J_{0};
  std::uint64_t allocations_{0};
  std::uint32_t lost_{0};
  bool finite_{true};
};

// Effective mass [kg] of the four corner contacts in parallel, between a box's face and the equal face of a box of
// `other` kg (0: fixed). `half`: half extents of both, z normal to the face; default: a cube.
double face_mass(double mass, double other, const Vec3d& half = {1, 1, 1});

// Angle between the body's z axis and the world's [rad].
double tilt_of(const Quatd& rotation);

}  // namespace tactus::hard_cases
