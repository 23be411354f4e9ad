// Rows of contacts against ghosts: each holds a contact in every lane, none of which share a member or a ghost.
//
// Solved as an inner contact (contact_row.h): on six numbers in the plane of its points, point after point. Side A is
// the ghost. It responds to a wrench by its admittance, and its motion within the step is taken to the first order.
// The stiffness is that of a contact of the two bodies alone, independent of what moves with the outside body, so that
// the overlap is the same in both worlds: with A = J W J^T of member and ghost, and A' that of the two bodies alone,
// its compliance is A' / a2 (softness.h).
// As the energy that the border may supply runs out (Allowance::supply, x), contacts become stiffer, the compliance
// x A' / a2, and correct their overlap more slowly, at x times the rate, so that a load rests at the same depth; and
// where the ghost approaches, its speed along the normal counts x times. At 0 an overlap stays, and the ghost counts as
// at rest. With a switch from one to the other instead, a body of 1000 kg that came to rest while the two worlds'
// borders ran out in different sub-steps was set down up to 0.2 mm beside: 7 of 32 runs of tests/border/thousand.toml
// with small changes were off by 21 to 26 % of the force, none by more than 1.7 % since (2026-11-30). Allowance::full_J
// is 10 mJ there; with 1 mJ one is off by 2.4 %, with 0.1 mJ two by 19 and 30 %.
//
// Frame: world; normal from the ghost to the member. Units: SI. Thread: [rt]. Bound: kMaxManifoldPoints points.
#pragma once

#include <span>

#include "rt/physics/body.h"
#include "rt/physics/border/border_contact.h"
#include "rt/physics/contact/contact_row.h"

namespace tactus::physics {

struct alignas(64) GhostRow {
  using V = Register<double>;
  static constexpr std::uint32_t kPoints = kMaxManifoldPoints;
  static constexpr int kWidth = kLanes<V>;
  using Lanes = std::uint32_t[kWidth];

  Lanes member, ghost;       // slot; index of the ghost
  std::uint32_t used{};      // lanes with a contact
  std::uint32_t points{};    // largest number of points of a lane
  bool slow{}, any_round{};  // swept twice; a lane's member is touched on a ball
  V inverse_mass;            // of the member, as the next
  SymMat3<V> inverse_inertia;
  AdmittanceOf<V> admittance;  // of the ghost
  Vec3<V> c_member, c_ghost;   // m, the plane's centre from the bodies' centres, at the start of the step

  // As in ContactRow, but for `mass_scale`.
  Vec3<V> n, t1, t2;
  SymBlock<V> w_normal;
  V x[kPoints], y[kPoints];
  V separation[kPoints], gap[kPoints];
  V mass_scale[kPoints];  // of the biased sweep: 1 / (1 + A' / (A a2))
  V normal_mass[kPoints], normal_impulse[kPoints];
  SymBlock<V> w_tangent;
  std::array<V, 9> w_cross;
  V friction;
  V tangent_mass[kPoints], tangent_impulse[2][kPoints];
  V total_normal_impulse[kPoints], total_tangent_impulse[2][kPoints];

  V member_share;                           // the member's part of A: the largest of the points
  V round;                                  // m, from the member's points back to the centre of a ball; else 0
  Vec3<V> start_v, start_w;                 // m/s, rad/s: of the member at the start of the sub-step
  V sub_step_work[kPoints], work[kPoints];  // J, done on the member in this sub-step, over the step
};

// A contact of a member with a ghost, to be solved.
struct GhostContact {
  std::span<const BorderContact> points;
  std::uint32_t slot;   // of the member
  const Posed& member;  // its pose at the start of the step
  const BorderGhost& ghost;
  double impulse_scale;  // of the impulses of the last step
  bool friction;         // the effect is on
};

// Fills a lane. A row with empty lanes must be cleared before.
void fill_lane(GhostRow& row, int lane, const GhostContact& contact, const SolverBodies<double>& bodies) noexcept;
// Fills the rest, once all lanes are filled.
void complete(GhostRow& row, const Softness<double>& softness) noexcept;

void begin_sub_step(GhostRow& row, const SolverBodies<double>& bodies) noexcept;  // before anything moves
void warm_start(GhostRow& row, const SolverBodies<double>& bodies, std::span<GhostState> ghosts) noexcept;
// The biased sweep; it takes the points first to last, the relax sweep last to first. `supply`: see Allowance.
void solve_biased(GhostRow& row, const SolverBodies<double>& bodies, std::span<GhostState> ghosts,
                  const SweepRule<double>& rule, double supply) noexcept;
void relax(GhostRow& row, const SolverBodies<double>& bodies, std::span<GhostState> ghosts,
           const SweepRule<double>& rule, double supply, bool friction) noexcept;
// Sets the points' work on the members in this sub-step: exactly the impulse times the mean of the velocities before
// and after.
void find_work(GhostRow& row, const SolverBodies<double>& bodies) noexcept;
// Reduces the work of points that supply energy to `share` of it: takes back part of the friction, and of the whole
// impulse if that is not enough or if the normal impulse itself supplies energy (work_limit.h). Points that take energy
// out go on to carry their load.
void keep_share(GhostRow& row, const SolverBodies<double>& bodies, std::span<GhostState> ghosts, double share) noexcept;
void scale_impulses(GhostRow& row, double factor) noexcept;
// Adds the sub-step's impulses and work to those of the step, and to the ghosts'.
void end_sub_step(GhostRow& row, std::span<GhostState> ghosts) noexcept;
// Stores the results of a lane in the points of its contact: the impulses of the last sub-step (those stored before
// plus `share` of the change), and sums, work and gaps of the step.
void store_impulses(const GhostRow& row, int lane, double share, std::span<BorderContact> points) noexcept;
void store_totals(const GhostRow& row, int lane, std::span<BorderContact> points) noexcept;

}  // namespace tactus::physics
