// Solves the border contacts of a world, in any mode: against ghosts, or against outside bodies given by their motion.
//
// In each mode one of the two solvers has rows, the other does nothing. Both limit the energy that the border puts into
// members to one allowance, from which joints to outside bodies draw as well.
// Frame: world. Units: SI. Thread: construction [setup], the rest [rt]. Bound: linear in border contacts and ghosts.
#pragma once

#include "rt/physics/border/ghost_solver.h"
#include "rt/physics/border/given_motion_solver.h"

namespace tactus::physics {

class BorderSolver {
 public:
  explicit BorderSolver(const Capacities& capacities) : ghosts_(capacities), given_(capacities.border_contacts) {}

  // `step.rule.available_J`: the energy that the border may put into members in this step; below 0: the energy that it
  // must take out of them first. In a sub-step that starts with nothing available the border only takes energy: an
  // approaching ghost counts as at rest along the normal (ghost_row.h), friction is limited to what does no work on the
  // member, and so is a replayed impulse. `bodies`: by slot, ascending ids. A contact whose member is missing exerts
  // nothing.
  void prepare(std::span<BorderContact> contacts, std::span<const BorderGhost> ghosts, std::span<const Body> bodies,
               SolverBodies<double> solver_bodies, const BorderStep& step) noexcept {
    allowance_ = {.available_J = step.rule.available_J, .full_J = traits_of(step.rule.mode).tank_at_start_J};
    ghosts_.prepare(contacts, ghosts, bodies, solver_bodies, step);
    given_.prepare(contacts, bodies, solver_bodies, step);
  }
  void begin_sub_step(std::uint32_t j, SolverBodies<double> bodies) noexcept {  // before anything moves
    ghosts_.begin_sub_step(bodies);
    given_.begin_sub_step(j, bodies);
  }
  // Call at the start of every sub-step, once joints' work is known: decides how much contacts may supply in it;
  // and before end_sub_step, with this sub-step's. `by_joints_J`: work of joints to outside bodies so far in the step.
  void count_joints(double by_joints_J) noexcept { allowance_.count_joints(by_joints_J); }
  bool may_supply() const noexcept { return allowance_.supply > 0.0; }
  double left_J() const noexcept { return allowance_.left_J(); }  // energy that the border may still supply
  void apply_replay(SolverBodies<double> bodies) noexcept { given_.apply_replay(bodies, may_supply()); }
  void warm_start(SolverBodies<double> bodies) noexcept {
    ghosts_.warm_start(bodies);
    given_.warm_start(bodies);
  }
  void solve_biased(SolverBodies<double> bodies, const SweepRule<double>& rule) noexcept {
    ghosts_.solve_biased(bodies, rule, allowance_.supply);
    given_.solve(bodies, rule, true, may_supply());
  }
  void relax(SolverBodies<double> bodies, const SweepRule<double>& rule, bool last) noexcept {
    ghosts_.relax(bodies, rule, allowance_.supply, last);
    given_.solve(bodies, rule, false, may_supply());
  }
  void move_ghosts() noexcept { ghosts_.move_ghosts(); }  // at the same place as the integration of the bodies
  void find_offsets(SolverBodies<double> bodies) noexcept {
    given_.find_offsets(bodies);
  }  // after all that moves bodies
  void end_sub_step(SolverBodies<double> bodies) noexcept {
    ghosts_.end_sub_step(bodies, allowance_);
    given_.end_sub_step(bodies, allowance_);
  }
  void scale_impulses(double factor) noexcept {
    ghosts_.scale_impulses(factor);
    given_.scale_impulses(factor);
  }
  // `share`: see ContactSolver::store. `bodies`: at the start of the step, `motion`: what they did since.
  void store(std::span<BorderContact> contacts, std::span<BorderGhost> ghosts, std::span<const Body> bodies,
             std::span<const SolverBody<double>> motion, double dt, double share) const noexcept {
    ghosts_.store(contacts, ghosts, bodies, motion, share);
    given_.store(contacts, dt, share);
  }
  void keep_impulses(std::span<BorderContact> contacts) const noexcept {
    ghosts_.keep_impulses(contacts);
    given_.keep_impulses(contacts);
  }
  // Valid from prepare to store, for joints, which act on them, too. In the order of the world's; empty without the
  // ghost border.
  std::span<GhostState> ghosts() noexcept { return ghosts_.ghosts(); }

 private:
  GhostSolver ghosts_;
  GivenMotionSolver given_;
  Allowance allowance_;
};

}  // namespace tactus::physics
