// How an outside body moves over a cycle, with all that hangs together with it: u and W of the ghost border.
//
// Contacts are springs with dampers (softness.h), and over a cycle T they give way. So the outside bodies take one step
// of implicit Euler over T: (M + G) v = p + P, with the masses M, the momenta p, an impulse P on the body that is asked
// about, and for each contact G = T c + T^2 k of the directions that it holds: its reduced mass times
// a2 = w T (2 z + w T). All bodies but the asked one are eliminated: v = W (p + P). A contact holds where, as it was in
// the last step, it can stop the motion of now: pressing, and within the disk of friction.
//
// The step is taken for what differs from the mean motion of the last step, and that goes on: u = v_mean + W M (v_end -
// v_mean). What creeps or settles under a load that stays does so without momentum, and goes on; what trembles on firm
// ground has at the end of a step any velocity, and that goes nowhere, since W M is near 0; what is free goes on as it
// moved at the end, since W M is 1. Of the motion in the next step each of the three alone foresees less: v_end lets a
// stack sway ever more (hard case 32: in antiphase from cycle to cycle), W M v_end stops what creeps (the pushed row of
// `experiment energy-loss` is then off by 1.8 % instead of 0.6 %, the pile by 2.0 instead of 0.5 %).
//
// Measured range of a2, on hard case 32 where it is 3,500: it rests with 200 to 10,000; with 100,000 it sways, since
// such contacts make ghosts that go on at the velocity of an instant and that nothing moves.
//
// Through contacts that press, an impulse reaches other outside bodies and static geometry at once. The contact graph
// is followed outwards from the body, nearest first, members left out, and every body is eliminated from the far end
// inwards (as an articulated body's inertia is found): exact where the graph is a tree. A body that can be reached in
// two ways hangs on the nearest; what holds it counts all the same. A contact holds along its normal, and across it
// where it sticks; a joint where its kind does, at its limits and where its motor holds, as firmly as a contact. A
// kinematic body gives way to nothing. Beyond kMostBodies the rest is left out: then the answer is too large, never too
// small; twice as many change the force error of `experiment energy-loss` by 0.1 % of the force (2026-11-22).
// Thread: the global world's; construction [setup]; allocates nothing. Frame: world. Units: SI. Work: index linear in
// contacts, find in kMostBodies. Source: the study of borders (Schur complement of the outside contact system);
// implicit integration of stiff contacts, Baraff and Witkin 1998; articulated-body inertia, Featherstone.
#pragma once

#include <array>
#include <vector>

#include "rt/physics/effects/joint.h"
#include "rt/physics/world.h"

namespace tactus::sim {

// Of six unknowns, velocity before spin: symmetric.
using Vector6 = std::array<double, 6>;
using Matrix6 = std::array<std::array<double, 6>, 6>;

// Over the cycle that comes: v = velocity + admittance P, P on its centre.
struct OutsideAnswer {
  Twistd velocity;  // m/s, rad/s: of the centre, without an impulse
  physics::Admittance admittance;
};

class ApparentInertia {
 public:
  static constexpr std::uint32_t kMostBodies = 16;

  ApparentInertia(std::uint32_t max_bodies, std::uint32_t max_contacts, std::uint32_t max_joints);

  // After a step of `step_s`: the world must stay as it is while it is asked about. `added_inertia`: a2 of contacts and
  // joints over the cycle to come.
  void index(const physics::World& world, double added_inertia, double step_s) noexcept;
  // Of a body's centre. `members` by slot: 1 for those that the sub-world moves.
  OutsideAnswer find(std::uint32_t slot, std::span<const std::uint8_t> members) noexcept;
  // What holds a body: the index of a contact, or of a joint beyond the contacts; and the slot at its other end,
  // physics::kNoSlot where that is static.
  struct Link {
    std::uint32_t index, other;
  };
  // The body's, contacts first, in their order.
  std::span<const Link> links_of(std::uint32_t slot) const noexcept;

 private:
  struct Held {  // a joint that is whole, and where its bodies are; A may be physics::kNoSlot: the world
    std::uint32_t a, b;
    const physics::Joint* joint;
    const physics::JointState* state;
  };
  struct Reached {
    std::uint32_t slot, parent, link;  // parent: index among the reached
    Matrix6 inertia;                   // about the asked body's centre, with all that hangs on it
    Matrix6 constraint_stiffness;      // of the link to the parent
    Vector6 momentum;                  // of the twist about that centre, with all that hangs on it
  };

  void collect(std::uint32_t slot, std::span<const std::uint8_t> members) noexcept;
  void reach(std::uint32_t slot, std::uint32_t parent, std::uint32_t link, const Vec3d& centre) noexcept;
  void find_joints(const physics::World& world) noexcept;
  // f(link, slot_a, slot_b), slot_b or slot_a physics::kNoSlot where that side is static: contacts, then joints.
  template <class F>
  void for_each_link(F&& f) const noexcept;
  Matrix6 constraint_stiffness_of(std::uint32_t link, const Vec3d& centre) const noexcept;
  Twistd mean_velocity(std::uint32_t slot) const noexcept;
  Twistd off_mean(std::uint32_t slot) const noexcept;  // velocity now, less the mean of the last step

  double added_inertia_{0}, step_s_{0};
  std::span<const physics::Contact> contacts_;
  std::span<const physics::Body> bodies_;
  std::span<const Posed> starts_;  // by slot, of the last step
  std::vector<Held> joints_;
  std::vector<std::uint8_t> immovable_;  // by slot
  std::vector<std::uint32_t> first_;     // by slot: its first link
  std::vector<Link> links_;
  std::vector<std::uint32_t> found_;  // by slot: the search that reached it
  std::uint32_t search_{0};
  std::vector<Reached> reached_;
};

}  // namespace tactus::sim
