// The energy budget of a border that has one. The border may supply to members only energy that it took from them
// before or that the outside bodies supplied in the global step, plus an initial amount
// (BorderTraits::budget_at_start_J).
//
// Per tick:
//   change of (stored - owed) = W_global / r - W_border,
// both are the work on members by normal and friction forces, with sign: where outside bodies take energy from members
// in the global step, the ghosts must take it too. In a sub-step the contact rows supply at most what is stored
// (BorderSolver::keep_budget); with an empty tank they only take energy. Joints, and outside bodies that take energy,
// may exceed the budget: the excess is owed and repaid first. So at any time contacts have supplied at most the initial
// amount plus the work of the outside bodies. Thread: [rt], the haptic thread. Units: J. Bound: constant time. Source:
// time-domain passivity, Hannaford, Ryu 2002; energy tanks, Franken et al. 2011.
#pragma once

#include <algorithm>

namespace tactus::haptics {

// Copied to the tape byte by byte: no padding.
struct BorderTank {
  // Capacity: limits how much of the energy taken long ago can be supplied at once.
  static constexpr double kMaxStored_J = 0.1;

  double stored_J{0}, owed_J{0};  // >= 0; at least one of them is 0
  double credit_J{0};             // per tick: work of the outside bodies on members in the last global step / r

  void start(double stored) noexcept { *this = {.stored_J = stored}; }
  // Energy that the border may supply in the next tick; below 0 it must take that much first.
  double budget_J(double credit) const noexcept { return stored_J - owed_J + std::max(0.0, credit); }
  // `energy`: credit minus work of the border, of one tick.
  void settle(double energy) noexcept {
    const double balance = stored_J - owed_J + energy;
    stored_J = std::clamp(balance, 0.0, kMaxStored_J);
    owed_J = std::max(0.0, -balance);
  }
  bool empty() const noexcept { return !(stored_J > 0); }
};

}  // namespace tactus::haptics
