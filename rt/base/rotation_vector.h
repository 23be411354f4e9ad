// Rotation vectors [rad] and their rates, for interpolating paths of rotations. Thread: [any]; pure, bounded.
//
// A rotation q(t) = exp(r(t)) q0 has the angular velocity w = J(r) dr/dt in world axes, where J is the left Jacobian of
// SO(3) (Sola et al., A micro Lie theory, 2018, equations 145 and 146). If r and dr/dt are parallel, w is dr/dt. Own
// arithmetic, so that every build has the same bits.
#pragma once

#include <algorithm>
#include <cmath>

#include "rt/base/spatial.h"

namespace tactus {

// The rotation vector of a unit quaternion, at most half a turn long: the inverse of quat_from_rotation_vector.
inline Vec3d rotation_vector_of(const Quatd& q) noexcept {
  const Vec3d v = q.w < 0.0 ? -q.vec() : q.vec();
  const double s = norm(v), c = std::abs(q.w);
  if (s < 1e-12) return 2.0 * v;
  // The angle whose sine and cosine are s and c, in [0, pi/2]: of the lesser the series of asin to x^7, then
  // x += sin(angle - x), which cubes the error. That starts below 0.003.
  const double x = std::min(s, c), x2 = x * x;
  const double of_lesser = x * (1 + x2 * (1.0 / 6 + x2 * (3.0 / 40 + x2 * (5.0 / 112))));
  double half_angle = s <= c ? of_lesser : 1.5707963267948966 - of_lesser;
  for (int i = 0; i < 2; ++i) {
    const auto so_far = sin_cos(half_angle);
    half_angle += s * so_far.cos - c * so_far.sin;
  }
  return v * (2.0 * half_angle / s);
}

// J(r) rate: the angular velocity for a rotation vector r that changes at `rate`.
inline Vec3d angular_velocity_of(const Vec3d& r, const Vec3d& rate) noexcept {
  const double square = dot(r, r), angle = std::sqrt(square);
  double a = 0.5 - square / 24, b = 1.0 / 6 - square / 120;
  if (angle > 1e-3) {
    const auto x = sin_cos(angle);
    a = (1 - x.cos) / square;
    b = (angle - x.sin) / (square * angle);
  }
  const Vec3d once = cross(r, rate);
  return rate + a * once + b * cross(r, once);
}

// The inverse of angular_velocity_of, for |r| below half a turn.
inline Vec3d rate_of_rotation_vector(const Vec3d& r, const Vec3d& angular_velocity) noexcept {
  const double square = dot(r, r), angle = std::sqrt(square);
  double b = 1.0 / 12 + square / 720;
  if (angle > 1e-3) {
    const auto x = sin_cos(angle);
    b = 1 / square - (1 + x.cos) / (2 * angle * x.sin);
  }
  const Vec3d once = cross(r, angular_velocity);
  return angular_velocity - 0.5 * once + b * cross(r, once);
}

}  // namespace tactus
