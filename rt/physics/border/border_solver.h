// Solves the border contacts of a world: rows between a member and an outside body, which is given by its motion.
//
// Modes and fields: border_contact.h. Per sub-step: [replay: applies the given impulse], warm start, and in every sweep
// the normal row (as for an inner contact: soft in the biased sweep, at velocity level in the relax sweep), then the
// two rows of the friction point: soft towards the line in the biased sweep, velocity level in the relax sweep, within
// the disk mu i. Against a ghost, friction is that of an inner contact: in the relax sweep only, within the disk of the
// row's own normal impulse.
// The stiffness of a row against a ghost is that of a contact of the two bodies alone, independent of what moves with
// the outside body, so that the overlap is the same in both worlds: with A = J W J^T of member and ghost, and A' that
// of the two bodies alone, its compliance is A' / a2 (softness.h).
// Frame: world. Units: SI. Thread: construction [setup], the rest [rt]. Bound: linear in border contacts.
#pragma once

#include <algorithm>
#include <span>

#include "rt/physics/border/border_contact.h"
#include "rt/physics/border/work_limit.h"
#include "rt/physics/contact/contact_solver.h"
#include "rt/physics/solver_body.h"

namespace tactus::physics {

// The step's parameters for the border.
struct BorderStep {
  BorderRule rule;
  double h;              // s: of a sub-step
  double impulse_scale;  // of the impulses of the last step, for the warm start
  SweepRule<double> sweep;
  bool friction;
};

class BorderSolver {
 public:
  explicit BorderSolver(std::uint32_t border_contacts)  // [setup]
      : rows_(border_contacts), pairs_(border_contacts), ghosts_(border_contacts) {}

  // `step.rule.available_J`: the energy that the border may put into members in this step; below 0: the energy that it
  // must take out of them first. In a sub-step that starts with nothing available the border only takes energy: an
  // approaching ghost counts as at rest along the normal, friction is limited to what does no work on the member, and
  // so is a replayed impulse. `bodies`: by slot, ascending ids. A contact whose member is missing exerts nothing.
  void prepare(std::span<BorderContact> contacts, std::span<const BorderGhost> ghosts, std::span<const Body> bodies,
               SolverBodies<double> solver_bodies, const BorderStep& step) noexcept;
  void begin_sub_step(std::uint32_t j, SolverBodies<double> bodies) noexcept;  // before anything moves
  // Call at the start of every sub-step, once joints' work is known: decides whether contacts may supply energy in it;
  // and before end_sub_step, with this sub-step's. `by_joints_J`: work of joints to outside bodies so far in the step;
  // what they have taken is left for the next step.
  void count_joints(double by_joints_J) noexcept {
    by_joints_J_ = std::max(0.0, by_joints_J);
    may_supply_ = left_J() > 0.0;
  }
  bool may_supply() const noexcept { return may_supply_; }
  double left_J() const noexcept { return available_J_ - by_joints_J_; }  // energy that the border may still supply
  void apply_replay(SolverBodies<double> bodies) noexcept;
  void warm_start(SolverBodies<double> bodies) noexcept;
  void solve(SolverBodies<double> bodies, const SweepRule<double>& rule, bool biased) noexcept;
  void move_ghosts() noexcept;                              // at the same place as the integration of the bodies
  void find_offsets(SolverBodies<double> bodies) noexcept;  // after all that moves bodies
  void end_sub_step(SolverBodies<double> bodies) noexcept;
  void scale_impulses(double factor) noexcept;
  // `share`: see ContactSolver::store.
  void store(std::span<BorderContact> contacts, std::span<BorderGhost> ghosts, double dt, double share) const noexcept;
  void keep_impulses(std::span<BorderContact> contacts) const noexcept { store_impulses(contacts, 1.0); }
  // Valid from prepare to store, for joints, which act on them, too. In the order of the world's; empty without the
  // ghost border.
  std::span<GhostState> ghosts() noexcept { return ghosts_.span(); }

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
    Vec3d offset;              // m, the same now; line_point moves with a ghost, but not yet with `outside_velocity`
    Vec3d outside_velocity;    // m/s
    double cap{}, friction{};  // N s; -
    double normal_mass{}, tangent_mass{};
    // Against a ghost: its index, the point from its centre [m], the change of its twist per unit impulse on the member
    // along n, t1, t2, A' / A along the normal, and the member's part of A.
    std::uint32_t ghost{kNoGhost};
    Vec3d ghost_r;
    double ghost_round{};    // m, from the centre of the ghost's ball or cap to the point
    Quatd rotation, turned;  // of the member: at the start of the step, and since
    Twistd ghost_answer[3];
    double member_share{};
    Softness<double> softness;  // of the biased sweep
    double max_push_speed{};    // m/s: greatest speed at which it corrects an overlap
    bool slow{false};
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
  };

  // The points of one pair of member and outside body, which are contiguous.
  struct Pair {
    double cap{}, sum{};  // N s per sub-step: limit, sum of the normal impulses
  };

  void init_ghost_row(Row& row, const BorderContact& contact, const BorderGhost& ghost, double inverse_mass,
                      const SymMat3d& inertia, const Vec3d& point) noexcept;
  static Vec3d rolled_at(const Row& row, const SolverBody<double>& body) noexcept;
  static void follow_ghost(const Row& row, const GhostState& ghost, const Vec3d& at, BorderContact& contact) noexcept;
  double normal_limit(const Row& row) const noexcept;
  static Vec3d offset_at(const Row& row, double elapsed) noexcept;
  Vec3d slip(const Row& row, const SolverBody<double>& body) const noexcept;
  void apply_impulse(const Row& row, SolverBody<double>& body, const SymMat3d& inertia, double normal, double tangent1,
                     double tangent2) noexcept;
  void apply_normal(const Row& row, SolverBody<double>& body, const SymMat3d& inertia, double normal) noexcept;
  void apply_tangents(const Row& row, SolverBody<double>& body, const SymMat3d& inertia, double tangent1,
                      double tangent2) noexcept;
  void solve_friction(Row& row, SolverBody<double>& body, const SymMat3d& inertia) noexcept;
  void mark_slow(std::span<Row> of_member) noexcept;
  Vec3d impulse_of(const Row& row) const noexcept;
  double work_of(const Row& row, const SolverBody<double>& body) const noexcept;
  void take_back_work(Row& row, SolverBody<double>& body, const SymMat3d& inertia, double allowed) noexcept;
  Works find_works(SolverBodies<double> bodies) noexcept;
  void keep_within_tank(SolverBodies<double> bodies) noexcept;
  void solve_friction_point(Row& row, SolverBody<double>& body, const SymMat3d& inertia, const SweepRule<double>& rule,
                            bool biased) noexcept;
  void solve_row(Row& row, SolverBodies<double> bodies, const SweepRule<double>& rule, bool biased) noexcept;
  void solve_normal(Row& row, SolverBody<double>& body, const SymMat3d& inertia, const SweepRule<double>& rule,
                    bool biased) noexcept;
  void store_impulses(std::span<BorderContact> contacts, double share) const noexcept;

  BoundedVector<Row> rows_;
  BoundedVector<Pair> pairs_;
  BoundedVector<GhostState> ghosts_;  // in the order of the world's ghosts
  double h_{};
  BorderTraits rule_;                     // of the mode
  bool may_supply_{true};                 // this sub-step started with some energy available
  double available_J_{}, by_joints_J_{};  // J: less the work of contacts so far; what joints supplied
};

}  // namespace tactus::physics
