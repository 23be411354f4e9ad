// Solves the contacts of a step: colours them, packs them into rows, sweeps over the rows and stores the impulses.
//
// A row holds contacts of one colour (contact_colours.h), as many as kWidth; contacts left over by the colouring get
// rows of one. Order in every sweep: colours between moving bodies, their left-over contacts, colours with fixed
// bodies, their left-over contacts. The order, and so the bits, do not depend on kWidth.
// Every sub-step is warm-started with the impulses of the previous one. Their effect on a body is the sum of the
// changes that the sweeps made to its velocity, which is kept per body; only the first warm start of a step goes
// through the rows.
// Rows of a colour share no body, so an executor may solve them in parallel, with the same bits.
// Frame: world. Units: SI. Thread: construction [setup]; the rest [rt]. Bound: linear in points; contacts and bodies up
// to the capacities given at construction.
#pragma once

#include <span>

#include "rt/physics/contact/contact_colours.h"
#include "rt/physics/contact/contact_row.h"
#include "rt/physics/contact/energy_gate.h"
#include "rt/physics/executor.h"

namespace tactus::physics {

template <class T, int kWidth = kLanes<Register<T>>>
class ContactSolver {
 public:
  explicit ContactSolver(const Capacities& capacities);  // [setup]

  // `dt` [s]: of the step. `executor`: used by all calls until the next prepare. The contacts are in double.
  void prepare(std::span<const Contact> contacts, SolverBodies<T> bodies, double dt,
               const Executor& executor = {}) noexcept;
  // Scaled down where it would raise the kinetic energy of an impact: see EnergyGate.
  void warm_start(SolverBodies<T> bodies, const SweepRule<T>& rule) noexcept;
  // Without that scaling.
  void warm_start_freely(SolverBodies<T> bodies) noexcept;
  void solve_biased(SolverBodies<T> bodies, const SweepRule<T>& rule, bool friction) noexcept;
  // `last`: also adds the impulses to the totals of the step.
  void relax(SolverBodies<T> bodies, const SweepRule<T>& rule, bool friction, bool last) noexcept;
  // For a sub-step without a relax sweep: adds its impulses to the totals.
  void add_to_totals() noexcept;
  void scale_impulses(T factor) noexcept;
  // Stores impulses and totals for the next step. `share` below 1 (see Solver): stores the impulses of the last
  // keep_impulses plus `share` of their change since.
  void store(std::span<Contact> contacts, double share) const noexcept;
  void keep_impulses(std::span<Contact> contacts) const noexcept;

 private:
  using V = std::conditional_t<kWidth == 1, T, Wide<T, kWidth>>;
  // Rows between moving bodies, then rows with fixed bodies from `first_fixed` on.
  template <class U>
  struct Rows {
    BoundedVector<ContactRow<U>> all;
    std::uint32_t first_fixed{0};
  };
  // First row of each colour; the next entry is its end.
  using Starts = std::array<std::uint32_t, ContactColours::kColours + 1>;

  using NextLanes = std::array<std::array<std::uint32_t, kMaxManifoldPoints>, ContactColours::kColours>;
  std::uint32_t place_colours(const ContactColours::Counts& counts, std::uint32_t row, Starts& starts) noexcept;
  static NextLanes lanes_by_points(const ContactColours::Counts& counts, const Starts& starts) noexcept;
  template <class F>
  void for_each_colour(const Starts& starts, F&& f) noexcept;
  template <class F>
  void for_each_row(F&& f) noexcept;
  template <class F>
  void for_each_row(F&& f) const noexcept;
  template <class F>
  void for_each_body(F&& f) noexcept;
  template <bool kTotals>
  void store_rows(std::span<Contact> contacts, double share) const noexcept;
  bool holds_impact(T impact_m_per_s) const noexcept;
  void hold_back_gain(SolverBodies<T> bodies, T impact_m_per_s) noexcept;
  void note_velocities(SolverBodies<T> bodies) noexcept;
  void add_change(SolverBodies<T> bodies) noexcept;
  template <bool kBias, bool kFriction, bool kTotals>
  void sweep(SolverBodies<T> bodies, const SweepRule<T>& rule) noexcept;

  ContactColours colours_;
  Rows<V> rows_;
  Rows<T> singles_;            // of contacts left over
  Starts moving_{}, fixed_{};  // into rows_
  Executor executor_;
  BoundedVector<Twist<T>> before_,
      accumulated_delta_v_;  // by slot: velocities before the sweep; change of velocity by the impulses of this
                             // sub-step
  bool given_is_known_{false};
  EnergyGate<T> gate_;
  // Normals: the reverse order from sweep to sweep and from sub-step to sub-step, so that the iteration is symmetric; a
  // constant order drives circular oscillations. Friction: the order of the Thue-Morse sequence from sub-step to
  // sub-step. With an order that alternates a cycle of two sub-steps can last: a cylinder that stood on a tray crept
  // by 12 mm in 6 s, by 0.003 mm since (2026-11-30).
  PointOrder order_;
  std::uint32_t sub_step_{0};
};

}  // namespace tactus::physics
