// How an outside body answers an impulse at the border, with all that moves with it: W of the ghost border.
//
// Through contacts that press, an impulse reaches other outside bodies and static geometry at once. The contact graph
// is followed outwards from the body, nearest first, members left out, and every body is eliminated from the far end
// inwards (as an articulated body's inertia is found): exact where the graph is a tree. A body that can be reached in
// two ways hangs on the nearest; what holds it counts all the same. A contact holds along its normal, and across it
// where it sticks; a joint where its kind does, at its limits and where its motor holds. A kinematic body gives way to
// nothing. Beyond kMostBodies the rest is left out: then the answer is too large, never too small; twice as many change
// the force error of `experiment energy-loss` by 0.1 % of the force (2026-11-22).
// Thread: the global world's; construction [setup]; allocates nothing. Frame: world. Units: SI. Work: index linear in
// contacts, find in kMostBodies. Source: the study of borders (Schur complement of the outside contact system);
// articulated-body inertia, Featherstone.
#pragma once

#include <array>
#include <vector>

#include "rt/physics/effects/joint.h"
#include "rt/physics/world.h"

namespace tactus::sim {

// Of six unknowns, velocity before spin: symmetric.
using Vector6 = std::array<double, 6>;
using Matrix6 = std::array<std::array<double, 6>, 6>;

class BorderAdmittance {
 public:
  static constexpr std::uint32_t kMostBodies = 16;

  BorderAdmittance(std::uint32_t max_bodies, std::uint32_t max_contacts, std::uint32_t max_joints);

  // After a step: the world must stay as it is while it is asked about, but for the bodies' velocities.
  void index(const physics::World<double>& world) noexcept;
  // Of a body's centre. `members` by slot: 1 for those that the sub-world moves.
  physics::Admittance<double> find(std::uint32_t slot, std::span<const std::uint8_t> members) noexcept;
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
    const physics::Joint<double>* joint;
    const physics::JointState<double>* state;
  };
  struct Reached {
    std::uint32_t slot, parent, link;  // parent: index among the reached
    Matrix6 inertia;                   // about the asked body's centre, with all that hangs on it
    Matrix6 firmness;                  // of the link to the parent
  };

  void collect(std::uint32_t slot, std::span<const std::uint8_t> members) noexcept;
  void reach(std::uint32_t slot, std::uint32_t parent, std::uint32_t link, const Vec3d& centre) noexcept;
  void find_joints(const physics::World<double>& world) noexcept;
  // f(link, slot_a, slot_b), slot_b or slot_a physics::kNoSlot where that side is static: contacts, then joints.
  template <class F>
  void for_each_link(F&& f) const noexcept;
  Matrix6 firmness_of(std::uint32_t link, const Vec3d& centre) const noexcept;

  std::span<const physics::Contact<double>> contacts_;
  std::span<const physics::Body<double>> bodies_;
  std::vector<Held> joints_;
  std::vector<std::uint8_t> immovable_;  // by slot
  std::vector<std::uint32_t> first_;     // by slot: its first link
  std::vector<Link> links_;
  std::vector<std::uint32_t> found_;  // by slot: the search that reached it
  std::uint32_t search_{0};
  std::vector<Reached> reached_;
};

}  // namespace tactus::sim
