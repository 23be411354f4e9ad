// Bounds of a body's motion: how far its surface may move in this step, and how far it has moved since the last one.
// From these narrow phase decides whether the last result for a pair is still valid. Units: SI. Thread: [any].
#pragma once

#include <algorithm>
#include <limits>

#include "rt/base/wide.h"
#include "rt/physics/body.h"
#include "rt/physics/step.h"

namespace tactus::physics {

struct MotionBound {
  double moved{}, fallen{};  // m, upper bounds in this step: of its surface by its velocity, by gravity
  Vec3d advance;             // m: part of `moved` by the centre's velocity; the rest has no known direction
  double rest{};             // m: the rest of `moved`
  Vec3d turn;                // rad: by the angular velocity in this step
  double driven{};           // m: part of `rest` that neither velocity causes, but a spring may
  double curve{};            // m: turn^2 / 2 times the body's radius, how far a point that turns leaves its tangent
  Vec3d shift;               // m, of the centre since the last step
  double turned{};           // rad since the last step, upper bound
  double slack{};            // m, rounding error of `shift`; infinite if the body was not in the last step
};

// Upper bound of the relative motion of two bodies' surfaces, up to `lever_arm` [m] from the centres, since the last
// step [m]. Zero for bodies that translate together.
inline double moved_against(const MotionBound& a, const MotionBound& b, double lever_arm) noexcept {
  return norm(b.shift - a.shift) + lever_arm * (a.turned + b.turned) + (a.slack + b.slack);
}

// Fall from rest in a step [m]. Semi-implicit Euler: with s sub-steps (1 + 1 / s) times the parabola.
inline double fall_in_step(const StepSettings& settings) noexcept {
  return 0.5 * (1.0 + 1.0 / static_cast<double>(settings.sub_steps)) * norm(settings.gravity) * settings.dt *
         settings.dt;
}

// Upper bound of the decrease of two bodies' distance in a step [m]. `advance`: the part that the centres' velocities
// cause [m].
// Gravity counts once: two bodies fall together, or one of them is supported.
inline double closing_with(double advance, const MotionBound& a, const MotionBound& b,
                           const StepSettings& settings) noexcept {
  return std::min(advance + (a.rest + b.rest) + larger(a.fallen, b.fallen), settings.max_margin);
}

// Upper bound of what a step may take from the distance of two bodies [m], if either keeps its velocity or stops:
//   sup over unit n of max(a.n, 0) + max(-b.n, 0) = max(|a|, |b|, |a - b|)
// for their advances a and b.
inline double closing_of(const MotionBound& a, const MotionBound& b, const StepSettings& settings) noexcept {
  const double advance =
      std::sqrt(larger(norm_squared(a.advance - b.advance), larger(norm_squared(a.advance), norm_squared(b.advance))));
  return closing_with(advance, a, b, settings);
}
// The same along the unit vector n from A to B.
inline double closing_along(const Vec3d& n, const MotionBound& a, const MotionBound& b,
                            const StepSettings& settings) noexcept {
  return closing_with(larger(dot(a.advance, n), 0.0) + larger(-dot(b.advance, n), 0.0), a, b, settings);
}

// Upper bound of what a step may take from the distance of a body to a fixed one along the unit vector d [m], if the
// body keeps either velocity or stops. `by_turn`: motion along d of the point in question by the body's turn alone, to
// first order [m]: d . (t x r) for the point r from the centre and the turn t. It is within t^2 / 2 |r| of that. Never
// more than closing_along, and less on the side from which the body turns away.
inline double closing_to_fixed(const MotionBound& bound, const Vec3d& d, double by_turn,
                               const StepSettings& settings) noexcept {
  const double rest = smaller(larger(by_turn, 0.0) + (bound.curve + bound.driven), bound.rest);
  return std::min(larger(dot(bound.advance, d), 0.0) + rest + bound.fallen, settings.max_margin);
}

// Distance to a fixed body up to which narrow phase is needed [m].
inline double margin_to_fixed(const MotionBound& bound, const StepSettings& settings) noexcept {
  const double closing = std::min(bound.moved + bound.fallen, settings.max_margin);
  return std::max(settings.min_margin, closing + carry_over_margin(settings));
}

// Growth of a body's bounds [m]: the growths of two bodies sum to at least the margin of their pair. Two bodies fall
// together, or one of them is supported, so each takes half of the fall, and half of carry_over_margin. `fall`:
// fall_in_step.
inline double growth_of(const MotionBound& bound, double fall, const StepSettings& settings) noexcept {
  const double heavier = std::max(bound.fallen - fall, 0.0);
  const double closing = std::min(bound.moved + 0.5 * fall + heavier, settings.max_margin);
  return 0.5 * carry_over_margin(settings) + std::max(0.5 * settings.min_margin, closing);
}

// Upper bound of margin_to_fixed - growth_of [m].
inline double growth_to_fixed(double fall, const StepSettings& settings) noexcept {
  return std::max(0.5 * settings.min_margin, 0.5 * (fall + carry_over_margin(settings)));
}

// An invalid pose, for a body that was not in the last step.
constexpr Posed unknown_pose() noexcept {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  return {{nan, nan, nan}, {nan, nan, nan, nan}};
}

// Fills `shift`, `turned` and `slack`. The motion bound is subtracted from distances of up to `far` [m], over many
// steps; `slack` covers the rounding error of those subtractions.
inline void measure_motion(const Posed& before, const Posed& now, double far, MotionBound& bound) noexcept {
  // Unit quaternions: |q - p| = 2 sin(angle / 4), and no axis turns by more than twice that. If q and p have opposite
  // signs, the result is far too large, which costs only time.
  const Quatd &p = before.rotation, &q = now.rotation;
  const double dw = q.w - p.w, dx = q.x - p.x, dy = q.y - p.y, dz = q.z - p.z;
  const Vec3d shift = now.position - before.position;
  const double shifted = norm(shift);
  const double turned = 2.0 * std::sqrt(dw * dw + dx * dx + dy * dy + dz * dz);
  constexpr double unknown = std::numeric_limits<double>::infinity(),
                   rounding = 2.0 * std::numeric_limits<double>::epsilon();
  bound.shift = {};
  bound.turned = bound.slack = 0.0;
  if (shifted == 0.0 && turned == 0.0) return;
  if (!(shifted < unknown && turned < unknown)) {  // or NaN
    bound.slack = unknown;
    return;
  }
  bound.shift = shift;
  bound.turned = turned * (1.0 + 8.0 * rounding);
  bound.slack = 4.0 * rounding * shifted + rounding * far;
}

}  // namespace tactus::physics
