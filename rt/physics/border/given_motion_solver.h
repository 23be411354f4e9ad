// Solves the border contacts of the modes without ghosts: rows between a member and an outside body, which is given by
// its motion.
//
// Modes and fields: border_contact.h. Per sub-step: [replay: applies the given impulse], warm start, and in every sweep
// the normal row (as for an inner contact: soft in the biased sweep, at velocity level in the relax sweep), then the
// two rows of the friction point: soft towards the line in the biased sweep, velocity level in the relax sweep, within
// the disk mu i. Sweeps are symmetric, as those of ghost_solver.h.
// Frame: world. Units: SI. Thread: construction [setup], the rest [rt]. Bound: linear in border contacts.
#pragma once

#include <algorithm>
#include <span>

#include "rt/base/bounded_vector.h"
#include "rt/physics/border/border_step.h"
#include "rt/physics/solver_body.h"

namespace tactus::physics {

class GivenMotionSolver {
 public:
  explicit GivenMotionSolver(std::uint32_t border_contacts)  // [setup]
      : rows_(border_contacts), pairs_(border_contacts) {}

  // With ghosts (`step.rule.mode`) it has no rows and does nothing. `bodies`: by slot, ascending ids. A contact whose
  // member is missing exerts nothing.
  void prepare(std::span<BorderContact> contacts, std::span<const Body> bodies, SolverBodies<double> solver_bodies,
               const BorderStep& step) noexcept;
  void begin_sub_step(std::uint32_t j, SolverBodies<double> bodies) noexcept;  // before anything moves
  void apply_replay(SolverBodies<double> bodies, bool may_supply) noexcept;
  void warm_start(SolverBodies<double> bodies) noexcept;
  void solve(SolverBodies<double> bodies, const SweepRule<double>& rule, bool biased, bool may_supply) noexcept;
  void find_offsets(SolverBodies<double> bodies) noexcept;  // after all that moves bodies
  // Limits the energy that rows put into members to `allowance`, and takes it from there. Rows that take energy out are
  // not changed.
  void end_sub_step(SolverBodies<double> bodies, Allowance& allowance) noexcept;
  void scale_impulses(double factor) noexcept;
  // `share`: see ContactSolver::store.
  void store(std::span<BorderContact> contacts, double dt, double share) const noexcept;
  void keep_impulses(std::span<BorderContact> contacts) const noexcept { store_impulses(contacts, 1.0); }

 private:
  struct Row {
    std::uint32_t slot{0};
    std::uint32_t pair{0};             // index into pairs_
    bool active{false}, holds{false};  // the member exists and is not frozen; friction acts
    Vec3d n, t1, t2;
    Vec3d r;                   // m, from the member's centre, at the start of the step
    Vec3d centre;              // m, same: of the ball that is touched, otherwise r
    double round{};            // m, from that centre to the point
    Vec3d rolled;              // m: by how much the point moved less than the member's material, over the step
    Vec3d start_offset;        // m, from line_point to the member's point, at the start of the step
    Vec3d offset;              // m, the same now; line_point does not yet move with `outside_velocity`
    Vec3d outside_velocity;    // m/s
    double cap{}, friction{};  // N s; -
    double normal_mass{}, tangent_mass{};
    double normal_impulse{}, tangent_impulse[2]{};
    double demand[2]{}, step_demand[2]{};  // N s: the impulse before the clamp to the disk; sum of the step
    double gap{};                          // m, at the start of the step
    double elapsed{};                      // s, time in the step at the start of the sub-step
    double error[2]{};                     // m, from the line, along t1 and t2, at the start of the sub-step
    Vec3d start_velocity;                  // m/s, of the point, at the start of the sub-step
    double step_normal{};
    double sub_step_work{}, work{};  // J, done on the member in this sub-step; over the step
    Vec3d step_tangent;

    bool presses() const noexcept {
      return normal_impulse != 0.0 || tangent_impulse[0] != 0.0 || tangent_impulse[1] != 0.0;
    }
    Vec3d impulse() const noexcept { return normal_impulse * n + tangent_impulse[0] * t1 + tangent_impulse[1] * t2; }
    Vec3d offset_at(double seconds) const noexcept { return offset - seconds * outside_velocity; }
    Vec3d slip(const SolverBody<double>& body) const noexcept { return velocity_at(body, r) - outside_velocity; }
    // The change of kinetic energy is exactly the impulse times the mean of the velocities before and after.
    double work_on(const SolverBody<double>& body) const noexcept {
      return 0.5 * dot(impulse(), start_velocity + velocity_at(body, r));
    }
  };

  // The points of one pair of member and outside body, which are contiguous.
  struct Pair {
    double cap{}, sum{};  // N s per sub-step: limit, sum of the normal impulses
  };

  static Vec3d rolled_at(const Row& row, const SolverBody<double>& body) noexcept;
  double normal_limit(const Row& row) const noexcept;
  void take_back_work(Row& row, SolverBody<double>& body, const SymMat3d& inertia, double allowed) noexcept;
  Works find_works(SolverBodies<double> bodies) noexcept;
  void keep_within_tank(SolverBodies<double> bodies, double left_J) noexcept;
  void solve_friction_point(Row& row, SolverBody<double>& body, const SymMat3d& inertia, const SweepRule<double>& rule,
                            bool biased, bool may_supply) noexcept;
  void solve_normal(Row& row, SolverBody<double>& body, const SymMat3d& inertia, const SweepRule<double>& rule,
                    bool biased, bool may_supply) noexcept;
  void store_impulses(std::span<BorderContact> contacts, double share) const noexcept;

  BoundedVector<Row> rows_;
  BoundedVector<Pair> pairs_;
  double h_{};
  BorderTraits rule_;  // of the mode
};

}  // namespace tactus::physics
