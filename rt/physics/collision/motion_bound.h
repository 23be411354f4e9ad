// How far a body's surface may move in a step, and how it has moved since the last one: what tells narrow phase that a
// pair is still as it was. Units: SI. Thread: [any].
#pragma once

#include <algorithm>
#include <limits>

#include "rt/physics/body.h"
#include "rt/physics/step.h"

namespace tactus::physics {

struct MotionBound {
  double moved{}, fallen{};  // m, in this step at most: by its velocity, by gravity
  Vec3d shift;               // m, of the centre since the last step
  double turned{};           // rad since the last step, at most
  double slack{};  // m, what rounding may have taken from `shift`; infinite where the last step did not know the body
};

// How far two bodies' surfaces, up to `lever_arm` [m] from the centres, have moved against each other since the last
// step [m, at most]. Bodies that move side by side have not.
inline double moved_against(const MotionBound& a, const MotionBound& b, double lever_arm) noexcept {
  return norm(b.shift - a.shift) + lever_arm * (a.turned + b.turned) + (a.slack + b.slack);
}

// How far a body falls in a step that begins at rest [m]. Semi-implicit: s sub-steps fall (1 + 1 / s) times the
// parabola.
inline double fall_in_step(const StepSettings& settings) noexcept {
  return 0.5 * (1.0 + 1.0 / static_cast<double>(settings.sub_steps)) * norm(settings.gravity) * settings.dt *
         settings.dt;
}

// How near a body must be to a fixed one to be compared with it [m].
inline double margin_to_fixed(const MotionBound& reach, const StepSettings& settings) noexcept {
  const double closing = std::min(reach.moved + reach.fallen, settings.max_margin);
  return std::max(settings.min_margin, closing + room_to_carry_over(settings));
}

// By how much a body's bounds grow [m]: those of two grow by at least the margin of their pair. Two bodies fall side by
// side, or one of them is held, so each takes half of the fall, and half of the room. `fall`: fall_in_step.
inline double growth_of(const MotionBound& reach, double fall, const StepSettings& settings) noexcept {
  const double heavier = std::max(reach.fallen - fall, 0.0);
  const double closing = std::min(reach.moved + 0.5 * fall + heavier, settings.max_margin);
  return 0.5 * room_to_carry_over(settings) + std::max(0.5 * settings.min_margin, closing);
}

// By how much bounds that have grown so are short of margin_to_fixed [m, at most].
inline double growth_to_fixed(double fall, const StepSettings& settings) noexcept {
  return std::max(0.5 * settings.min_margin, 0.5 * (fall + room_to_carry_over(settings)));
}

// A pose that is no pose: of a body that the last step did not know.
constexpr Posed unknown_pose() noexcept {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  return {{nan, nan, nan}, {nan, nan, nan, nan}};
}

// Fills `shift`, `turned` and `slack`. What comes of them is subtracted from distances of at most `far` [m], over many
// steps: the slack of what has moved covers what such a difference may lose to rounding too.
inline void measure_motion(const Posed& before, const Posed& now, double far, MotionBound& reach) noexcept {
  // Unit quaternions: |q - p| = 2 sin(angle / 4), and no axis turns by more than twice that. Of a quaternion and its
  // negative, the same rotation, this says much too much, which only costs time.
  const Quatd &p = before.rotation, &q = now.rotation;
  const double dw = q.w - p.w, dx = q.x - p.x, dy = q.y - p.y, dz = q.z - p.z;
  const Vec3d shift = now.position - before.position;
  const double shifted = norm(shift);
  const double turned = 2.0 * std::sqrt(dw * dw + dx * dx + dy * dy + dz * dz);
  constexpr double unknown = std::numeric_limits<double>::infinity(),
                   rounding = 2.0 * std::numeric_limits<double>::epsilon();
  reach.shift = {}, reach.turned = reach.slack = 0.0;
  if (shifted == 0.0 && turned == 0.0) return;
  if (!(shifted < unknown && turned < unknown)) {  // a NaN too
    reach.slack = unknown;
    return;
  }
  reach.shift = shift;
  reach.turned = turned * (1.0 + 8.0 * rounding);
  reach.slack = 4.0 * rounding * shifted + rounding * far;
}

}  // namespace tactus::physics
