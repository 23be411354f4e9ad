// The contacts of a step as rows for the sweeps: coloured, packed into lanes, solved, and their impulses given back.
//
// A row holds contacts of one colour (contact_colours.h), as many as kWidth; contacts that no colour has room for are
// rows of one. Order in every sweep: colours between moving bodies, what they left over, colours with fixed bodies,
// what they left over. The order does not depend on kWidth, so neither do the bits.
// Every sub-step starts with the impulses of the one before. What they do to a body is the sum of what the sweeps have
// done to it so far, which is kept by body: only the first warm start of a step goes through the rows.
// Rows of a colour share no body, so an executor may have them solved at the same time: that does not show in the bits.
// Frame: world. Units: SI. Thread: construction [setup]; the rest [rt]. Bound: linear in points; as many contacts and
// bodies as given at construction.
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

  // `executor`: for all that follows, up to the next prepare. The contacts' numbers are double.
  void prepare(std::span<const Contact> contacts, SolverBodies<T> bodies, const Executor& executor = {}) noexcept;
  // Held back where it would give energy: see EnergyGate.
  void warm_start(SolverBodies<T> bodies, const SweepRule<T>& rule) noexcept;
  // The same, whatever it gives.
  void warm_start_freely(SolverBodies<T> bodies) noexcept;
  void solve_biased(SolverBodies<T> bodies, const SweepRule<T>& rule, bool friction) noexcept;
  // `last`: also adds the impulses to the totals of the step.
  void relax(SolverBodies<T> bodies, const SweepRule<T>& rule, bool friction, bool last) noexcept;
  // For a sub-step without a relax sweep: adds the impulses to the totals as they are.
  void add_to_totals() noexcept;
  void scale_impulses(T factor) noexcept;
  // Impulses and totals, for the next step. `share`: see Solver. Below 1 the impulses stored are those of the last
  // keep_impulses, and that share of what came since.
  void store(std::span<Contact> contacts, double share) const noexcept;
  void keep_impulses(std::span<Contact> contacts) const noexcept;

 private:
  using V = std::conditional_t<kWidth == 1, T, Wide<T, kWidth>>;
  // Rows of one kind: those between moving bodies come first.
  template <class U>
  struct Rows {
    BoundedVector<ContactRow<U>> all;
    std::uint32_t first_fixed{0};
  };
  // The rows of each colour: from its own start to the next one's.
  using Starts = std::array<std::uint32_t, ContactColours::kColours + 1>;

  std::uint32_t place_colours(const ContactColours::Counts& counts, std::uint32_t row, Starts& starts) noexcept;
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
  bool holds_blow(T blow_m_per_s) const noexcept;
  void hold_back_gain(SolverBodies<T> bodies, T blow_m_per_s) noexcept;
  void note_velocities(SolverBodies<T> bodies) noexcept;
  void add_change(SolverBodies<T> bodies) noexcept;
  template <bool kBias, bool kFriction, bool kTotals>
  void sweep(SolverBodies<T> bodies, const SweepRule<T>& rule) noexcept;
  template <bool kBias, bool kFriction, bool kTotals, bool kBackwards>
  void sweep_points(SolverBodies<T> bodies, const SweepRule<T>& rule) noexcept;

  ContactColours colours_;
  Rows<V> rows_;
  Rows<T> singles_;            // of contacts left over
  Starts moving_{}, fixed_{};  // of rows_
  Executor executor_;
  BoundedVector<Twist<T>> before_,
      accumulated_delta_v_;  // by slot: velocities before the sweep; what this sub-step's impulses gave
  bool given_is_known_{false};
  EnergyGate<T> gate_;
  // Which way round the next sweep takes the points of a contact, and the first of the next sub-step. To and fro, in
  // turns also from sub-step to sub-step, is symmetric; always the same way round drives what sways in circles.
  bool backwards_{false}, next_backwards_{false};
};

}  // namespace tactus::physics
