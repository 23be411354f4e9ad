// What crosses the border between members and outside bodies, as the global world sees it: down, the impulses of its
// last step at the border contacts, and for ghosts how the outside bodies move and answer; up, the impulses that the
// sub-world found there.
//
// The intervals. H(n) tells what the sub-world did over cycle n-1, from t_(n-1) to t_n. The global step over the same
// time is the one before the step that H(n) starts: its contacts are still in the world when H(n) is taken. So J_sub
// of the report and J_global of those contacts are two answers for one interval, and only their difference is news to
// the outside body. Replay hands on J_sub itself, as the paper says: friction then counts in both worlds. Friction
// alone is handed on; the members that are imposed press by themselves. With the ghost border the sub-world has moved
// the outside body already, so the whole difference goes back, normal part too: momentum is handed on exactly.
// Thread: the global world's; construction [setup]. Frame: world. Units: SI. Bound: kMaxBorderPoints points; beyond,
// those that press least are left out, ties by order, and counted. Source: the paper, section 2.2.
#pragma once

#include <vector>

#include "rt/haptics/snapshot.h"
#include "sim/interface/border_admittance.h"

namespace tactus::sim {

// What one hand-back did to outside bodies.
struct HandBack {
  Vec3d impulse_Ns;          // sum
  double magnitude_Ns{0};    // sum of the magnitudes
  double energy_J{0};        // kinetic energy that the outside bodies gained
  std::uint32_t skipped{0};  // returns to bodies that are members by now: their own world moves them
};

// A body as it is after a step, and where it was before it; a fixed one stays.
struct BodyOverStep {
  const physics::Body<double>& body;
  const Posed& start;
};
// A point of a contact, seen from the member's side, after a step of `step_s`; without what only ghosts need.
haptics::BorderPoint border_point(const physics::Contact<double>& contact, const physics::ContactPoint<double>& point,
                                  bool member_is_a, const BodyOverStep& member, const BodyOverStep& outside,
                                  double step_s) noexcept;

class BorderLog {
 public:
  BorderLog(std::uint32_t max_bodies, std::uint32_t max_contacts, std::uint32_t max_joints);

  // Fills `border` from the contacts of a step of `step_s` that began at `start` (poses by slot): every point that
  // pressed or overlaps, between a member (by slot, 1) and a dynamic body that is none. Static geometry is never a
  // border. Returns how many did not fit.
  std::uint32_t fill(std::span<const physics::Contact<double>> contacts, std::span<const physics::Body<double>> bodies,
                     std::span<const Posed> start, std::span<const std::uint8_t> members, double step_s,
                     FixedVector<haptics::BorderPoint, haptics::kMaxBorderPoints>& border) noexcept;
  // The outside bodies of these border points, by id, after a step of `step_s` in sub-steps. `members`: of the cycle
  // that comes; `former`: of the step's own. Returns how many did not fit: their points stay without a ghost.
  std::uint32_t fill_outside(const physics::World<double>& world, std::span<const std::uint8_t> members,
                             std::span<const std::uint8_t> former, double step_s, double sub_step_s,
                             std::span<const haptics::BorderPoint> border,
                             FixedVector<haptics::OutsideBody, haptics::kMaxOutsideBodies>& outside) noexcept;
  // Of the ghost border, before the next step: what the sub-world did to the outside bodies, normal part too, less what
  // the members' images did in the last step, given to each and to what moved with it in that cycle, as the ghosts took
  // it: one that has become a member since goes along, or else what it stands on is thrown against it. Where a body
  // slides on static geometry, what that takes changes its friction too: else a row whose first outside body is lifted
  // a little by its neighbour's image brakes too late. A late cycle, longer than the global step of `step_ticks`,
  // counts as its mean. `members`: of the cycle that begins.
  HandBack hand_back(const haptics::SubWorldReport& report, std::uint32_t step_ticks,
                     std::span<const std::uint8_t> members, physics::World<double>& world) noexcept;

 private:
  struct News {  // for an outside body
    std::uint32_t slot;
    Wrenchd impulse;
  };

  Wrenchd load_on(std::uint32_t slot, const physics::World<double>& world, std::span<const std::uint8_t> former,
                  double step_s) const noexcept;
  Wrenchd friction_with(const Vec3d& held_Ns, std::uint32_t slot, const physics::World<double>& world) const noexcept;
  void add_news(std::uint32_t slot, const Wrenchd& impulse) noexcept;

  std::vector<haptics::BorderPoint> points_;
  std::vector<std::uint32_t> order_;
  std::vector<BodyId> ids_;
  std::vector<News> news_;
  std::vector<std::uint8_t> reported_;  // by slot: it was a member of the cycle that is handed back
  BorderAdmittance admittance_;
};

// Applies the report's tangential impulses to the outside bodies. Call before the next step. `members` by slot: of
// the cycle that begins.
HandBack hand_back_border(std::span<const haptics::BorderReturn> returns, std::span<const std::uint8_t> members,
                          physics::BorderMode mode, physics::World<double>& world) noexcept;

}  // namespace tactus::sim
