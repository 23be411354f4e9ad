// What crosses the border between members and outside bodies, as the global world sees it: down, the impulses of its
// last step at the border contacts, and for ghosts how the outside bodies move and answer; up, the impulses that the
// sub-world found there.
//
// The intervals. H(n) tells what the sub-world did over cycle n-1, from t_(n-1) to t_n. The global step over the same
// time is the one before the step that H(n) starts: its contacts are still in the world when H(n) is taken. The borders
// capped and replay, filtered or not, return impulses. Replay returns J_sub itself, as the paper says: friction then
// counts in both worlds. Capped returns the difference to J_global of those contacts. Friction alone is returned; the
// members that are imposed press by themselves. The ghost border returns nothing: what stands at it is the global
// world's to move (rt/haptics/coupling/border_buffer.h).
// Thread: the global world's; construction [setup]. Frame: world. Units: SI. Bound: kMaxBorderPoints points; beyond,
// those that press least are left out, ties by order, and counted. Source: the paper, section 2.2.
#pragma once

#include <vector>

#include "rt/haptics/coupling/snapshot.h"
#include "sim/exchange/apparent_inertia.h"

namespace tactus::sim {

// What the return of one cycle did to outside bodies.
struct ImpulseReturn {
  Vec3d impulse_Ns;          // sum
  double magnitude_Ns{0};    // sum of the magnitudes
  double energy_J{0};        // kinetic energy that the outside bodies gained
  std::uint32_t skipped{0};  // returns to bodies that are members by now: their own world moves them
};

// A body as it is after a step, and where it was before it; a fixed one stays.
struct BodyOverStep {
  const physics::Body& body;
  const Posed& start;
};
// A point of a contact, seen from the member's side, after a step of `step_s`; without what only ghosts need.
haptics::BorderPoint border_point(const physics::Contact& contact, const physics::ContactPoint& point, bool member_is_a,
                                  const BodyOverStep& member, const BodyOverStep& outside, double step_s) noexcept;

class BorderExchange {
 public:
  // `added_inertia`: apparent_inertia.h.
  BorderExchange(std::uint32_t max_bodies, std::uint32_t max_contacts, std::uint32_t max_joints, double added_inertia);

  // Fills `border` from the contacts of a step of `step_s` that began at `start` (poses by slot): every point that
  // pressed or overlaps, between a member (by slot, 1) and a dynamic body that is none. Static geometry is never a
  // border. Returns how many did not fit.
  std::uint32_t fill(std::span<const physics::Contact> contacts, std::span<const physics::Body> bodies,
                     std::span<const Posed> start, std::span<const std::uint8_t> members, double step_s,
                     FixedVector<haptics::BorderPoint, haptics::kMaxBorderPoints>& border) noexcept;
  // The outside bodies of these border points and of the joints that hold members, by id, after a step of `step_s` in
  // sub-steps. `members`: of the cycle that comes. Returns how many did not fit: their points stay without a ghost.
  //
  // A body's drive is what acts on it but the members: with its acceleration a over the step, as far as that will go
  // on, and the wrench P / step_s that the members had on it about its centre, a - W P / step_s. Where it rests on firm
  // ground W is 0, and so is the drive.
  std::uint32_t fill_outside(const physics::World& world, std::span<const std::uint8_t> members, double step_s,
                             double sub_step_s, std::span<const haptics::BorderPoint> border,
                             FixedVector<haptics::OutsideBody, haptics::kMaxOutsideBodies>& outside) noexcept;

 private:
  std::vector<haptics::BorderPoint> points_;
  std::vector<std::uint32_t> order_;
  // What members do to an outside body, over the last step.
  struct Load {
    BodyId outside;
    Vec3d force, point;  // N, m: world
    Vec3d torque;        // N m
  };
  void collect_loads(const physics::World& world, std::span<const std::uint8_t> members,
                     std::span<const haptics::BorderPoint> border) noexcept;

  double added_inertia_;
  std::vector<Load> loads_;
  ApparentInertia admittance_;
};

// The work of bodies that are no members on members (by slot, 1) over a step [J], by contacts and joints, with sign:
// each impulse times the mean of its point's velocities on the member before (`before`, by slot) and after the step,
// which is how the sum over all impulses on a body changes its kinetic energy. Static geometry is never a border.
double border_work_J(const physics::World& world, std::span<const Twistd> before, std::span<const std::uint8_t> members,
                     double step_s) noexcept;

// Applies the report's tangential impulses to the outside bodies, as the border returns them. Call before the next
// step. `members` by slot: of the cycle that begins.
ImpulseReturn return_impulses(std::span<const haptics::BorderReturn> returns, std::span<const std::uint8_t> members,
                              physics::BorderTraits::Return returned, physics::World& world) noexcept;

}  // namespace tactus::sim
