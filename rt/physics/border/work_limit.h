// Limits the work that impulses of rows do on bodies: the share of it that rows may keep, and how much of an impulse to
// take back for that.
//
// An impulse J changes its point's velocity from v0 to v1, and does the work J . v, v = (v0 + v1) / 2. If the share x
// of its part D is added, the velocity changes by x A D, A: the inverse effective mass, and the work is
//   W = J . v + x (D . v + J A D / 2) + x^2 D A D / 2
// Pure functions. Units: SI.
#pragma once

#include <algorithm>
#include <cmath>

namespace tactus::physics {

// A border with less than this share of its initial energy counts as one that has nothing left: what is left approaches
// 0 and does not reach it, since ghosts act less and less (ghost_row.h).
inline constexpr double kEmptyShare = 0.01;

constexpr bool is_empty(double left_J, double full_J) noexcept { return !(left_J > kEmptyShare * full_J); }

// The energy that the border may put into members in a step.
struct Allowance {
  double available_J{};  // less the work of contacts so far; below 0: it must take that out first
  double full_J{};       // with so much left and more, ghosts act as if nothing limited them
  double by_joints_J{};  // what joints to outside bodies supplied; what they took is left for the next step
  // Of this sub-step, by what was left at its start: in [0, 1]; at 0 the border only takes.
  double supply{1.0};

  double left_J() const noexcept { return available_J - by_joints_J; }
  void count_joints(double joints_J) noexcept {
    by_joints_J = std::max(0.0, joints_J);
    supply = left_J() > 0.0 ? std::min(1.0, left_J() / full_J) : 0.0;
  }
};

// J, of all rows in a sub-step: of those that supply energy; of all.
struct Works {
  double given{}, sum{};

  void add(double work) noexcept {
    given += std::max(0.0, work);
    sum += work;
  }
};

// Share of their work that the rows which supply energy may keep, so that the sum is at most `left` [J]; 1 if it is.
inline double share_kept(const Works& works, double left) noexcept {
  return works.sum <= left || !(works.given > 0.0) ? 1.0 : std::max(0.0, left) / works.given;
}

// The share x of D to add, the root nearest 0 in [-1, 0] of W = the allowed work; -1 if there is none.
// `slope`: D . v + J A D / 2 [J]; `square`: D A D [J]; `beyond`: J . v less the allowed work [J].
inline double share_taken_back(double slope, double square, double beyond) noexcept {
  const double root = slope * slope - 2.0 * square * beyond;
  const double sum = slope + std::sqrt(std::max(0.0, root));
  return root >= 0.0 && sum > 0.0 ? std::max(-1.0, -2.0 * beyond / sum) : -1.0;
}

}  // namespace tactus::physics
