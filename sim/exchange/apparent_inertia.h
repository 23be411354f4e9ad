// The apparent inertia of an outside body over a cycle, coupled to all bodies connected to it: the admittance W and the
// predicted velocity u of the ghost border.
//
// Contacts are spring-dampers (softness.h) and yield over a cycle T. The outside bodies take one step of implicit Euler
// over T:
//   (M + G) v = p + P    M: masses; p: momenta; P: an impulse on the queried body
//   G = T c + T^2 k      per contact, in the directions that it constrains: its reduced mass times a2
//   a2 = w T (2 z + w T)   w, z: the contacts' angular frequency and damping ratio
// All bodies but the queried one are eliminated: v = W (p + P). A contact constrains a direction if, with its load of
// the last step, it can stop the present motion: it keeps pressing, and its friction stays within the friction disk.
//
// The step is applied to the deviation from a reference motion, which continues:
//   u = v_mean + W sum M (v_end - v_ref)
// v_ref: every body's mean twist over the last step, and so v_mean for the queried body. A body that creeps or settles
// under a constant load does so without momentum, and continues. But bodies that met within the step approached each
// other in the mean, which their contact will not let them do again: there v_ref is the rigid motion with the body
// before it. The velocity of a body at rest on firm ground fluctuates within a step, so its value at the end is
// arbitrary; it has no effect since W M is near 0. A free body continues at v_end, since W M is 1. Simpler predictions
// are worse: with v_end alone a stack sways increasingly (hard case 32: in antiphase from cycle to cycle); W M v_end
// stops creep (the pushed row of `experiment energy-loss` is then off by 1.8 % instead of 0.6 %, the pile by 2.0
// instead of 0.5 %).
//
// Measured range of a2, on hard case 32 where it is 3,500: at rest with 200 to 10,000. With 100,000 it sways: such
// stiff contacts make ghosts that keep an instantaneous velocity and that no impulse changes.
//
// An impulse reaches other outside bodies and static geometry at once, through contacts that press. The search follows
// the contact graph outwards from the body, breadth first, without members, and eliminates every body from the far end
// inwards, as in the articulated-body algorithm. This is exact where the graph is a tree. A body with two paths is
// attached by the shortest; its contacts with static geometry count in any case. A contact constrains motion along its
// normal, and in the tangent plane too if it sticks. A joint constrains the directions of its kind, and its coordinate
// at a limit or with a motor that is not overcome, as stiffly as a contact. A kinematic body has infinite inertia.
// Bodies beyond kMaxBodies are left out: W is then too large, never too small. Twice as many change the force error of
// `experiment energy-loss` by 0.1 % of the force (2026-11-22).
//
// Thread: the global world's; construction [setup]; allocates nothing. Frame: world. Units: SI. Work: index linear in
// contacts, find in kMaxBodies. Source: Schur complement of the outside bodies' contact system, above; implicit
// integration of stiff contacts, Baraff and Witkin 1998; articulated-body inertia, Featherstone.
#pragma once

#include <array>
#include <vector>

#include "rt/physics/effects/joint.h"
#include "rt/physics/slot_index.h"
#include "rt/physics/world.h"

namespace tactus::sim {

// Six components, linear before angular; matrices are symmetric.
using Vector6 = std::array<double, 6>;
using Matrix6 = std::array<std::array<double, 6>, 6>;

// Motion of an outside body over the next cycle: v = velocity + admittance P, for an impulse P at its centre.
struct OutsideAnswer {
  Twistd velocity;  // m/s, rad/s: u, at the centre, without an impulse
  physics::Admittance admittance;
};

class ApparentInertia {
 public:
  static constexpr std::uint32_t kMaxBodies = 16;
  static constexpr physics::SlotIndex kStatic{physics::kNoSlot};  // of static geometry, and of the world

  ApparentInertia(std::uint32_t max_bodies, std::uint32_t max_contacts, std::uint32_t max_joints);

  // Reads the world after a step of `step_s`; the world must not change before the last find(). `added_inertia`: a2 [-]
  // of contacts and joints over the next cycle.
  void index(const physics::World& world, double added_inertia, double step_s) noexcept;
  // Motion of a body's centre. `members`, by slot: 1 for bodies that the sub-world moves.
  OutsideAnswer find(physics::SlotIndex slot, std::span<const std::uint8_t> members) noexcept;
  // Admittance of the body alone, as if nothing held it.
  physics::Admittance free_admittance(physics::SlotIndex slot) const noexcept;
  // A constraint on a body. `index`: of a contact, or contacts + index of a joint. `other`: the other body, or kStatic.
  struct Link {
    std::uint32_t index;
    physics::SlotIndex other;
  };
  // The constraints on a body: contacts, then joints, each in their order.
  std::span<const Link> links_of(physics::SlotIndex slot) const noexcept;

 private:
  struct JointLink {  // an unbroken joint and the slots of its bodies; A may be kStatic: the world
    physics::SlotIndex a, b;
    const physics::Joint* joint;
    const physics::JointState* state;
  };
  struct Visited {
    physics::SlotIndex slot;
    std::uint32_t parent, link;    // parent: index in visited_
    Vector6 mean, reference;       // twists at the queried body's centre: over the last step; v_ref
    Matrix6 inertia;               // about the queried body's centre, its subtree included
    Matrix6 constraint_stiffness;  // G of the link to the parent
    Vector6 momentum;              // about that centre, its subtree included
  };

  void collect(physics::SlotIndex slot, std::span<const std::uint8_t> members) noexcept;
  void visit(physics::SlotIndex slot, std::uint32_t parent, std::uint32_t link, const Vec3d& centre) noexcept;
  void add_other_parts(Visited& from, const Vec3d& centre) const noexcept;
  void find_joints(const physics::World& world) noexcept;
  // Calls f(link, slot_a, slot_b) for contacts, then joints; a slot is kStatic where that side is static.
  template <class F>
  void for_each_link(F&& f) const noexcept;
  const physics::Body& body(physics::SlotIndex slot) const noexcept { return bodies_[number_of(slot)]; }
  bool is_immovable(physics::SlotIndex slot) const noexcept { return immovable_[number_of(slot)] != 0; }
  // G of a link.
  Matrix6 stiffness_of_joint(const JointLink& link, const Vec3d& centre) const noexcept;
  Matrix6 constraint_stiffness_of(std::uint32_t link, const Vec3d& centre) const noexcept;
  bool is_new(std::uint32_t link) const noexcept;  // its bodies were apart at the start of the last step
  Twistd mean_velocity(physics::SlotIndex slot) const noexcept;
  Twistd off_mean(physics::SlotIndex slot) const noexcept;  // present velocity minus the mean

  double added_inertia_{0}, step_s_{0};
  std::span<const physics::Contact> contacts_;
  std::span<const physics::Body> bodies_;
  std::span<const Posed> starts_;  // by slot: pose at the start of the last step
  std::vector<JointLink> joints_;
  std::vector<std::uint8_t> immovable_;  // by slot: 1 if kinematic
  std::vector<std::uint32_t> first_;     // by slot: its first link
  std::vector<Link> links_;
  std::vector<std::uint32_t> found_;  // by slot: number of the last search that reached it
  std::uint32_t search_{0};
  std::vector<Visited> visited_;
};

}  // namespace tactus::sim
