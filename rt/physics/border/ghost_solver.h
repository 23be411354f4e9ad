// Solves the border contacts against ghosts (border_ghost.h): packs them into rows and sweeps over the rows.
//
// A row holds contacts that share neither a member nor a ghost (ghost_row.h). Each contact, in the order of the border
// contacts, gets the first colour that neither of its bodies has; where all are taken, a row of its own.
// Biased sweeps go forwards, relax sweeps backwards: the iteration is symmetric, so its eigenvalues are real and in
// [0, 1) (Saad, Iterative Methods for Sparse Linear Systems, 2003, section 4.1). In one direction only they are
// complex, and the errors of many coupled rows oscillate: the load on a plank of tests/border/crib.toml (shares 14/15)
// oscillated by a third of its mean, and the proxy crept along it. With the symmetric order it oscillates by 4.5 %,
// with the slow rows swept twice by 1.5 %.
// Frame: world. Units: SI. Thread: construction [setup], the rest [rt]. Bound: linear in border contacts and ghosts.
#pragma once

#include <array>
#include <span>

#include "rt/base/bounded_vector.h"
#include "rt/physics/border/border_step.h"
#include "rt/physics/border/ghost_row.h"
#include "rt/physics/capacity.h"

namespace tactus::physics {

class GhostSolver {
 public:
  explicit GhostSolver(const Capacities& capacities);  // [setup]

  // Without ghosts (`step.rule.mode`) it has no rows and does nothing. A contact whose member is missing or frozen, or
  // whose ghost is, exerts nothing. `bodies`: by slot, ascending ids.
  void prepare(std::span<BorderContact> contacts, std::span<const BorderGhost> ghosts, std::span<const Body> bodies,
               SolverBodies<double> solver_bodies, const BorderStep& step) noexcept;
  void begin_sub_step(SolverBodies<double> bodies) noexcept;  // before anything moves
  void warm_start(SolverBodies<double> bodies) noexcept;
  void solve_biased(SolverBodies<double> bodies, const SweepRule<double>& rule, double supply) noexcept;
  // Friction, as of inner contacts, in the last relax sweep of a sub-step alone (contact_row.h).
  void relax(SolverBodies<double> bodies, const SweepRule<double>& rule, double supply, bool last) noexcept;
  void move_ghosts() noexcept;  // at the same place as the integration of the bodies
  // Limits the energy that contacts put into members to `allowance`, and takes it from there. Contacts that take energy
  // out are not changed.
  void end_sub_step(SolverBodies<double> bodies, Allowance& allowance) noexcept;
  void scale_impulses(double factor) noexcept;
  // `share`: see ContactSolver::store. `bodies`: at the start of the step; `motion`: what they did since.
  void store(std::span<BorderContact> contacts, std::span<BorderGhost> ghosts, std::span<const Body> bodies,
             std::span<const SolverBody<double>> motion, double share) const noexcept;
  void keep_impulses(std::span<BorderContact> contacts) const noexcept;
  // Valid from prepare to store, for joints, which act on them, too. In the order of the world's.
  std::span<GhostState> ghosts() noexcept { return ghosts_.span(); }

 private:
  static constexpr std::uint32_t kColours = 64, kOwnRow = kColours;  // one bit each in a mask
  static constexpr auto kWidth = static_cast<std::uint32_t>(GhostRow::kWidth);

  // A contact: the points of one pair of bodies with one normal, at most as many as a row takes.
  struct Group {
    std::uint32_t first{}, count{}, slot{}, ghost{};
    std::uint32_t colour{}, row{}, lane{};
  };

  void find_groups(std::span<BorderContact> contacts, std::span<const Body> bodies,
                   SolverBodies<double> solver_bodies) noexcept;
  void place_groups() noexcept;
  void mark_slow_rows() noexcept;
  void mark_slow_rows(std::span<const Group> of_member) noexcept;

  BoundedVector<Group> groups_;
  BoundedVector<std::uint64_t> of_member_, of_ghost_;  // colours taken, by slot and by ghost
  BoundedVector<GhostRow> rows_;
  BoundedVector<GhostState> ghosts_;  // in the order of the world's ghosts
  double h_{};
};

}  // namespace tactus::physics
