// The energy budget of a border that has one: what it puts into members it must have taken out before, or the outside
// bodies must have given it in the global step; and a little to start with (BorderTraits::budget_at_start_J).
//
// Of a tick
//   change of (stored - owed) = W_global / r - W_border,
// both works on members, normal and friction, with sign: where outside bodies take energy from members in the global
// step, ghosts must take it too. A sub-step's contact rows give no more than is stored (BorderSolver::keep_budget),
// with an empty tank they only take; joints, and outside bodies that take, may go beyond: that is owed and paid first.
// So at any time contacts have put in at most what was there at the start and what outside bodies did. Thread: [rt],
// the haptic thread. Units: J. Bound: constant time. Source: time-domain passivity, Hannaford, Ryu 2002; energy tanks,
// Franken et al. 2011.
#pragma once

#include <algorithm>

namespace tactus::haptics {

// Copied to the tape byte by byte: no padding.
struct BorderTank {
  // It holds no more, so that what was taken out long ago is not put in at once.
  static constexpr double kMostStored_J = 0.1;

  double stored_J{0}, owed_J{0};  // 0 or more; one of them is 0
  double credit_J{0};             // of a tick: the outside bodies' work in the last global step / r

  void start(double stored) noexcept { *this = {.stored_J = stored}; }
  // What the border may put in in the next tick; below 0 it must take that much first.
  double budget_J(double credit) const noexcept { return stored_J - owed_J + std::max(0.0, credit); }
  // `energy`: credit - work of the border, of a tick.
  void settle(double energy) noexcept {
    const double balance = stored_J - owed_J + energy;
    stored_J = std::clamp(balance, 0.0, kMostStored_J);
    owed_J = std::max(0.0, -balance);
  }
  bool empty() const noexcept { return !(stored_J > 0); }
};

}  // namespace tactus::haptics
