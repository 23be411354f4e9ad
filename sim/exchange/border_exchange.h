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
// Durations of a step whose bodies fill_outside reads [s].
struct StepTimes {
  double step_s, sub_step_s;  // of the step, or of its last macro step
  double cycle_s;             // of the cycle over which the outside bodies' motion is predicted
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
  // A body's drive is its acceleration due to everything but the members: a - W L. a: its acceleration over the step,
  // where it is expected to continue; L: the members' wrench on it, about its centre, as far as it lasts. Where the
  // body rests on firm ground, W is 0 and so is the drive. For a body that no member touches yet, W is the admittance
  // of the body alone: its contacts with the ground, which hold it at rest, do not stop it in an impact.
  //
  // An impact is no lasting load: were its mean over the step in L, the ghost would be driven against the member by as
  // much for a whole cycle. So L is at most kGrowth times what it was after the step before.
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
  struct ForceOn {
    BodyId outside;
    double force_N;  // of the members on it, as found: before the limit
  };
  // Share of the load that counts as lasting; notes it for the next step.
  double lasting_share(BodyId outside, const Wrenchd& load) noexcept;
  void collect_loads(const physics::World& world, std::span<const std::uint8_t> members,
                     std::span<const haptics::BorderPoint> border) noexcept;

  double added_inertia_;
  std::vector<Load> loads_;
  std::vector<ForceOn> force_now_, force_before_;  // after this step and the one before; the latter by body
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
