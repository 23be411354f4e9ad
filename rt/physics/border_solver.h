// Solves the border contacts of a world: rows against a body that this world knows only by its motion.
//
// Modes and fields: border_contact.h. Per sub-step: [replay: the impulse itself], warm start, and in every sweep the
// normal row (as an inner contact's: soft in the biased sweep, at velocity level in the relax sweep), then the friction
// point's two rows: soft towards the line in the biased sweep, velocity level in the relax sweep, within the disk mu i.
// Frame: world. Units: SI. Thread: construction [setup], the rest [rt]. Bound: linear in border contacts.
#pragma once

#include <span>

#include "rt/physics/border_contact.h"
#include "rt/physics/contact_solver.h"
#include "rt/physics/solver_body.h"

namespace tactus::physics {

template <class T>
class BorderSolver {
 public:
  explicit BorderSolver(std::uint32_t border_contacts) : rows_(border_contacts), pairs_(border_contacts) {}  // [setup]

  // `bodies`: by slot, ascending ids. A contact whose member is not there exerts nothing.
  void prepare(std::span<BorderContact<T>> contacts, BorderMode mode, std::span<const Body<T>> bodies,
               SolverBodies<T> solver_bodies, T h, T impulse_scale, bool friction) noexcept;
  void begin_sub_step(std::uint32_t j, SolverBodies<T> bodies) noexcept;  // before anything moves: books
  void apply_replay(SolverBodies<T> bodies) noexcept;
  void warm_start(SolverBodies<T> bodies) noexcept;
  void solve(SolverBodies<T> bodies, const SweepRule<T>& rule, bool biased) noexcept;
  void end_sub_step(SolverBodies<T> bodies) noexcept;
  void scale_impulses(T factor) noexcept;
  // `share` as for contacts.
  void store(std::span<BorderContact<T>> contacts, T dt, T share) const noexcept;
  void keep_impulses(std::span<BorderContact<T>> contacts) const noexcept { store_impulses(contacts, T(1)); }

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
    T normal_impulse{}, tangent_impulse[2]{};
    T demand[2]{}, step_demand[2]{};  // N s: what the rows would have taken without the disk; sum of the step
    T gap{};                          // m, at the start of the step
    T elapsed{};                      // s, of the step, at the start of the sub-step
    T error[2]{};                     // m, off the line at the start of the sub-step
    Vec3<T> start_velocity;           // m/s, of the point
    T step_normal{}, work{};
    Vec3<T> step_tangent;
  };

  // The points of one member and one outside body, which follow each other.
  struct Pair {
    T cap{}, sum{};  // N s per sub-step: allowed, applied
  };

  T normal_limit(const Row& row) const noexcept;
  T gap_at(const Row& row, const SolverBody<T>& body, T elapsed) const noexcept;
  void press(Row& row, SolverBody<T>& body, const SymMat3<T>& inertia, const SweepRule<T>& rule, bool biased) noexcept;
  void store_impulses(std::span<BorderContact<T>> contacts, T share) const noexcept;

  BoundedVector<Row> rows_;
  BoundedVector<Pair> pairs_;
  BorderMode mode_{BorderMode::kCapped};
  T h_{};
};

}  // namespace tactus::physics
