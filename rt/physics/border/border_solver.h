// Solves the border contacts of a world: rows against a body that this world knows only by its motion.
//
// Modes and fields: border_contact.h. Per sub-step: [replay: the impulse itself], warm start, and in every sweep the
// normal row (as an inner contact's: soft in the biased sweep, at velocity level in the relax sweep), then the friction
// point's two rows: soft towards the line in the biased sweep, velocity level in the relax sweep, within the disk mu i.
// Against a ghost friction is an inner contact's: in the relax sweep, within the disk of the row's own normal impulse.
// A row's spring is that of the two bodies, whatever moves with the outside one: with A = J W J^T of member and ghost,
// A' that of the two bodies alone, it gives way by A' / a2 (softness.h), so that both worlds sink equally deep.
// Frame: world. Units: SI. Thread: construction [setup], the rest [rt]. Bound: linear in border contacts.
#pragma once

#include <span>

#include "rt/physics/border/border_contact.h"
#include "rt/physics/contact/contact_solver.h"
#include "rt/physics/solver_body.h"

namespace tactus::physics {

template <class T>
class BorderSolver {
 public:
  explicit BorderSolver(std::uint32_t border_contacts)  // [setup]
      : rows_(border_contacts), pairs_(border_contacts), ghosts_(border_contacts) {}

  // `budget_J`: what the border may put into members in the step; below 0, what it must take first. While nothing is
  // left of it, sub-step by sub-step, it only takes: to members ghosts do not approach, and their friction, or what is
  // replayed, is limited to what does no work on the member.
  // `bodies`: by slot, ascending ids. A contact whose member is not there exerts nothing.
  void prepare(std::span<BorderContact<T>> contacts, std::span<const BorderGhost<T>> ghosts, BorderMode mode,
               std::span<const Body<T>> bodies, SolverBodies<T> solver_bodies, T h, T impulse_scale, bool friction,
               T budget_J) noexcept;
  void begin_sub_step(std::uint32_t j, SolverBodies<T> bodies) noexcept;  // before anything moves: books
  void apply_replay(SolverBodies<T> bodies) noexcept;
  void warm_start(SolverBodies<T> bodies) noexcept;
  void solve(SolverBodies<T> bodies, const SweepRule<T>& rule, bool biased) noexcept;
  void move_ghosts() noexcept;  // where the bodies move
  void end_sub_step(SolverBodies<T> bodies) noexcept;
  void scale_impulses(T factor) noexcept;
  // `share` as for contacts.
  void store(std::span<BorderContact<T>> contacts, std::span<BorderGhost<T>> ghosts, T dt, T share) const noexcept;
  void keep_impulses(std::span<BorderContact<T>> contacts) const noexcept { store_impulses(contacts, T(1)); }
  // From prepare to store: joints act on them, too. In the order of the world's; none without the ghost border.
  std::span<GhostState<T>> ghosts() noexcept { return ghosts_.span(); }

 private:
  struct Row {
    std::uint32_t slot{0};
    std::uint32_t pair{0};             // index into pairs_
    bool active{false}, holds{false};  // the member is there; the friction point holds
    Vec3<T> n, t1, t2;
    Vec3<T> r;                   // m, from the member's centre, at the start of the step
    Vec3<T> offset;              // m, of the member's point from line_point, at the start of the step
    Vec3<T> neighbour_velocity;  // m/s
    T cap{}, friction{};         // N s; -
    T normal_mass{}, tangent_mass{};
    // Against a ghost: which, the point from its centre [m], what a unit impulse on the member along n, t1, t2 does to
    // it, A' / A of the normal, and the member's part of A.
    std::uint32_t ghost{kNoGhost};
    Vec3<T> ghost_r;
    Twist<T> ghost_answer[3];
    T own_share{1}, member_share{};
    bool slow{false};
    T normal_impulse{}, tangent_impulse[2]{};
    T demand[2]{}, step_demand[2]{};  // N s: what the rows would have taken without the disk; sum of the step
    T gap{};                          // m, at the start of the step
    T elapsed{};                      // s, of the step, at the start of the sub-step
    T error[2]{};                     // m, off the line at the start of the sub-step
    T end_gap{};                      // m, and the member's point from line_point: at the end of the sub-step
    Vec3<T> end_offset;
    Vec3<T> start_velocity;  // m/s, of the point
    T step_normal{}, work{};
    Vec3<T> step_tangent;
  };

  // The points of one member and one outside body, which follow each other.
  struct Pair {
    T cap{}, sum{};  // N s per sub-step: allowed, applied
  };

  void meet_ghost(Row& row, const BorderContact<T>& contact, const BorderGhost<T>& ghost, T inverse_mass,
                  const SymMat3<T>& inertia, const Vec3<T>& point) noexcept;
  T normal_limit(const Row& row) const noexcept;
  Vec3<T> offset_at(const Row& row, const SolverBody<T>& body, T elapsed) const noexcept;
  Vec3<T> slip(const Row& row, const SolverBody<T>& body) const noexcept;
  void push(const Row& row, SolverBody<T>& body, const SymMat3<T>& inertia, T normal, T tangent1, T tangent2) noexcept;
  void rub(Row& row, SolverBody<T>& body, const SymMat3<T>& inertia) noexcept;
  void mark_slow(std::span<Row> of_member) noexcept;
  Vec3<T> impulse_of(const Row& row) const noexcept;
  T work_of(const Row& row, const SolverBody<T>& body) const noexcept;
  void take_back_work(Row& row, SolverBody<T>& body, const SymMat3<T>& inertia, T allowed) noexcept;
  void keep_budget(SolverBodies<T> bodies) noexcept;
  void hold_on_line(Row& row, SolverBody<T>& body, const SymMat3<T>& inertia, const SweepRule<T>& rule,
                    bool biased) noexcept;
  void solve_row(Row& row, SolverBodies<T> bodies, const SweepRule<T>& rule, bool biased) noexcept;
  void press(Row& row, SolverBody<T>& body, const SymMat3<T>& inertia, const SweepRule<T>& rule, bool biased) noexcept;
  void store_impulses(std::span<BorderContact<T>> contacts, T share) const noexcept;

  BoundedVector<Row> rows_;
  BoundedVector<Pair> pairs_;
  BoundedVector<GhostState<T>> ghosts_;  // as the world's
  T h_{};
  BorderTraits rule_;    // of the mode
  bool may_give_{true};  // in the sub-step: something is left of the budget
  T budget_J_{};         // what is left of it
};

}  // namespace tactus::physics
