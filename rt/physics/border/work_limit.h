// Takes back part of an impulse that does more work on a body than it may.
//
// An impulse J changes its point's velocity from v0 to v1, and does the work J . v, v = (v0 + v1) / 2. If the share x
// of its part D is added, the velocity changes by x A D, A: the inverse effective mass, and the work is
//   W = J . v + x (D . v + J A D / 2) + x^2 D A D / 2
// Pure functions. Units: SI.
#pragma once

#include <algorithm>
#include <cmath>

namespace tactus::physics {

// The share x of D to add, the root nearest 0 in [-1, 0] of W = the allowed work; -1 if there is none.
// `slope`: D . v + J A D / 2 [J]; `square`: D A D [J]; `beyond`: J . v less the allowed work [J].
inline double share_taken_back(double slope, double square, double beyond) noexcept {
  const double root = slope * slope - 2.0 * square * beyond;
  const double sum = slope + std::sqrt(std::max(0.0, root));
  return root >= 0.0 && sum > 0.0 ? std::max(-1.0, -2.0 * beyond / sum) : -1.0;
}

}  // namespace tactus::physics
