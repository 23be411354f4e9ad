// The energy tank of a border that has one. The border may supply to members only energy that it took from them
// before or that the outside bodies supplied in the global step, plus an initial amount
// (BorderTraits::tank_at_start_J).
//
// Per cycle:
//   change of (stored - owed) = W_global - W_border - W_push - W_corrections
// W_border, the work of the border on members, contacts and joints, is settled tick by tick. At the synchronisation
// follow, all with sign: W_global, the work of the outside bodies on members over the same cycle in the global step;
// W_corrections, the energy that the corrections of that cycle gave (border_correction.h); W_push, the work of position
// correction (rt/physics/push_out.h), which W_global contains, too: what rests on a border that gives way loses
// potential energy without moving at the end of any sub-step.
//
// In a sub-step contacts and joints supply at most what is available (BorderSolver, Joints::keep_within_tank);
// with nothing available they only take energy. Below 1 % of the initial amount the tank counts as empty
// (physics::is_empty).
//
// What is settled at the synchronisation, and outside bodies that take energy, may exceed it: the excess is owed and
// repaid first. Outside bodies in motion do work on members, which the balance knows only at the end of the cycle. So
// the border may owe kCreditShare of their kinetic energy K (WorldSnapshot::outside_motion_J). That is bounded, too: if
// G is what border and corrections supplied beyond the outside bodies' work, E_0 the initial amount and K_0 the kinetic
// energy without G, K is at most K_0 + G, so
//   G <= E_0 + kCreditShare (K_0 + G) <= (E_0 + kCreditShare K_0) / (1 - kCreditShare)
// What the damper between device and proxy takes, and what members dissipate between them by friction, in contacts and
// joints (SubWorld::note_dissipation), fills the tank up to the initial amount: else a balance that is a little short
// after an impact would stay so. So border and corrections have supplied at most the initial amount, the work of the
// outside bodies, what was dissipated, and what is owed; in their own sub-step contacts and joints owe nothing. Thread:
// [rt], the haptic thread. Units: J. Bound: constant time. Source: time-domain passivity, Hannaford, Ryu 2002; energy
// tanks, Franken et al. 2011.
#pragma once

#include <algorithm>

#include "rt/physics/border/work_limit.h"

namespace tactus::haptics {

// Copied to the tape byte by byte: no padding.
struct BorderTank {
  // Capacity between cycles: limits how much of the energy taken long ago can be supplied at once.
  static constexpr double kMaxStored_J = 0.1;

  // Share of the outside bodies' kinetic energy that the border may owe; bounded below 1. Measured range: from 0.25 to
  // 0.9 the same (tests/border/README.md).
  static constexpr double kCreditShare = 0.5;

  double stored_J{0}, owed_J{0};  // >= 0; at least one of them is 0
  double credit_J{0};             // what it may owe

  void start(double balance) noexcept {
    stored_J = std::max(0.0, balance);
    owed_J = std::max(0.0, -balance);
  }
  void lend(double outside_motion_J) noexcept { credit_J = kCreditShare * outside_motion_J; }
  double balance_J() const noexcept { return stored_J - owed_J; }
  // Energy that the border may supply in the next tick; below 0 it must take that much first.
  double available_J() const noexcept { return balance_J() + credit_J; }
  void settle(double energy) noexcept { start(balance_J() + energy); }
  // Adds energy that was dissipated, until `most` is stored again. Returns what it added.
  double refill(double dissipated, double most) noexcept {
    const double added = std::clamp(most - balance_J(), 0.0, dissipated);
    if (added > 0.0) settle(added);
    return added;
  }
  // Once a cycle, when all of it is settled. Within a cycle the energy of an impact may be on one side of the balance
  // only.
  void keep_capacity() noexcept { stored_J = std::min(stored_J, kMaxStored_J); }
  bool empty(double initial_J) const noexcept { return physics::is_empty(available_J(), initial_J); }
};

}  // namespace tactus::haptics
