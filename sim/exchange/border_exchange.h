// The global world's side of the border between members and outside bodies. To the sub-world: the impulses of the last
// global step at the border contacts and, for ghosts, the outside bodies' predicted motion and admittance. From the
// sub-world: the impulses that it applied there.
//
// Cycle: H(n) reports what the sub-world did over cycle n-1, from t_(n-1) to t_n. The global step over the same time is
// the one before the step that H(n) starts, so its contacts are still in the world when H(n) is read.
//
// Returned to the outside bodies, by BorderTraits::returns:
//   kImpulse (replay, filtered)  J_sub, as in the paper: friction then acts in both worlds
//   kChange (capped, frozen)     J_sub minus J_global of those contacts
//   kNothing (ghost)             nothing here: the global world returns what its prediction of the sub-world did not
//                                have (sim/exchange/sub_world_prediction.h)
// Only friction is returned; the imposed members transmit the normal force themselves.
//
// Thread: the global world's; construction [setup]. Frame: world. Units: SI. Bound: kMaxBorderPoints points; beyond,
// those with the least normal force are left out, ties by order, and counted. Source: the paper, section 2.2.
#pragma once

#include <vector>

#include "rt/haptics/coupling/snapshot.h"
#include "sim/exchange/apparent_inertia.h"
#include "sim/exchange/approach.h"

namespace tactus::sim {

// Effect of one cycle's returned impulses on the outside bodies.
struct ImpulseReturn {
  Vec3d impulse_Ns;          // sum
  double magnitude_Ns{0};    // sum of the magnitudes
  double energy_J{0};        // kinetic energy that the outside bodies gained
  std::uint32_t skipped{0};  // entries for bodies that have become members: the sub-world moves them
};

// A body after a step, and its pose at the start of the step; the same pose for a fixed body.
struct BodyOverStep {
  const physics::Body& body;
  const Posed& start;
};
// A world's contacts after a step.
struct StepContacts {
  std::span<const physics::Contact> contacts;
  std::span<const physics::Body> bodies;  // by slot
  std::span<const Posed> start;           // by slot: poses at the start of the step
  double step_s;
};

// A contact point from the member's side, after a step of `step_s`. The fields that only ghosts need are not filled.
haptics::BorderPoint border_point(const physics::Contact& contact, const physics::ContactPoint& point, bool member_is_a,
                                  const BodyOverStep& member, const BodyOverStep& outside, double step_s) noexcept;

class BorderExchange {
 public:
  // `added_inertia`: a2 of apparent_inertia.h.
  BorderExchange(std::uint32_t max_bodies, std::uint32_t max_contacts, std::uint32_t max_joints, double added_inertia);

  // Call before each step.
  void begin_step() noexcept;

  // Fills `border` from a step's contacts between a member (`members`, by slot: 1) and a dynamic body that is not a
  // member: every point with a normal impulse or an overlap, and with `near_points` every point that narrow phase
  // found. Contacts with static geometry are not border contacts. Returns the number of points that did not fit.
  std::uint32_t fill(const StepContacts& step, std::span<const std::uint8_t> members, bool near_points,
                     FixedVector<haptics::BorderPoint, haptics::kMaxBorderPoints>& border) noexcept;
  // Appends the points of approaching pairs that have no contact, for ghosts. Without them a member overlaps an outside
  // body until the global step has found their contact, two cycles later. Returns the number of points that did not
  // fit.
  std::uint32_t add_approaching(std::span<const Approaching> pairs, const StepContacts& step,
                                std::span<const std::uint8_t> members,
                                FixedVector<haptics::BorderPoint, haptics::kMaxBorderPoints>& border) noexcept;
  // Fills `outside` with the outside bodies of these border points and of joints to members, by id, after a step.
  // `members`: of the next cycle. Returns the number of bodies that did not fit: their points have no ghost.
  //
  // A body's drive is its acceleration due to everything but the members, as far as it lasts: W (f - L). f: the force
  // that moved it and what is connected to it (apparent_inertia.h); L: the members' wrench on it, about its centre.
  // Where the body rests on firm ground, W is 0 and so is the drive. For a body that no member touches yet, W is the
  // admittance of the body alone: its contacts with the ground, which hold it at rest, do not stop it in an impact.
  //
  // An impact does not last: were its mean over the step in the drive, the ghost would be driven against the member, or
  // away from it, by as much for a whole cycle. So of a drive that changed by more than its value after the step
  // before, what the two have in common counts. f is of the last macro step, where a body at rest trembles: W f is at
  // most 1.5 times the body's mean acceleration since the step before. A body that was not at the border then counts
  // with its load alone.
  std::uint32_t fill_outside(const physics::World& world, std::span<const std::uint8_t> members, const StepTimes& times,
                             std::span<const haptics::BorderPoint> border,
                             FixedVector<haptics::OutsideBody, haptics::kMaxOutsideBodies>& outside) noexcept;

 private:
  std::vector<haptics::BorderPoint> points_;
  std::vector<std::uint32_t> order_;
  // Members' load on an outside body, mean over the last step.
  struct Load {
    BodyId outside;
    bool touches;
    Vec3d force, point;  // N; m
    Vec3d torque;        // N m
  };
  struct Known {  // an outside body after a step
    BodyId id;
    Twistd velocity;
    Twistd drive;  // W (f - L), m/s^2, rad/s^2
  };
  // The part that lasts of the drive, given W f and W L; notes the body for the next step.
  Twistd lasting_drive(const physics::Body& outside, const Twistd& acceleration, const Twistd& under_load,
                       double cycle_s) noexcept;
  void collect_loads(const physics::World& world, std::span<const std::uint8_t> members,
                     std::span<const haptics::BorderPoint> border) noexcept;

  double added_inertia_;
  std::vector<Load> loads_;
  std::vector<Known> known_now_, known_before_;  // after this step and the one before; the latter by id
  ApparentInertia admittance_;
};

// Work [J] of outside bodies on members (`members`, by slot: 1) over a step, through contacts and joints, with sign:
// each impulse times the mean of its point's velocities on the member before (`before`, by slot) and after the step.
// Summed over all impulses on a body this is its change of kinetic energy. Contacts with static geometry do not count.
double border_work_J(const physics::World& world, std::span<const Twistd> before, std::span<const std::uint8_t> members,
                     double step_s) noexcept;

// Work [J] of position correction on members over a step (rt/physics/push_out.h). `spring`: of their device.
double push_out_J(const physics::World& world, std::span<const Twistd> before, std::span<const std::uint8_t> members,
                  double step_s, const Vec3d& gravity, const physics::PoseSpring& spring) noexcept;

// Applies the report's tangential impulses to the outside bodies, as the border's traits `returned` specify. Call
// before the next step. `members`, by slot: of the cycle that begins. Entries that are not finite are ignored.
ImpulseReturn return_impulses(std::span<const haptics::BorderReturn> returns, std::span<const std::uint8_t> members,
                              physics::BorderTraits::Return returned, physics::World& world) noexcept;

// Applies these impulses, about the bodies' centres. Call before the next step.
ImpulseReturn return_impulses(std::span<const haptics::OutsideImpulse> impulses, physics::World& world) noexcept;

}  // namespace tactus::sim
