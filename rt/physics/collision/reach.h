// How far a body's surface may move in a step, and how it has moved since the last one: what tells narrow phase that a
// pair is still as it was. Units: SI. Thread: [any].
#pragma once

#include <algorithm>
#include <limits>

#include "rt/physics/body.h"
#include "rt/physics/step.h"

namespace tactus::physics {

template <class T>
struct Reach {
  T moved{}, fallen{};  // m, in this step at most: by its velocity, by gravity
  Vec3<T> shift;        // m, of the centre since the last step
  T turned{};           // rad since the last step, at most
  T slack{};  // m, what rounding may have taken from `shift`; infinite where the last step did not know the body
};

// How far two bodies' surfaces, up to `lever` [m] from the centres, have moved against each other since the last step
// [m, at most]. Bodies that move side by side have not.
template <class T>
T moved_against(const Reach<T>& a, const Reach<T>& b, T lever) noexcept {
  return norm(b.shift - a.shift) + lever * (a.turned + b.turned) + (a.slack + b.slack);
}

// How far a body falls in a step that begins at rest [m]. Semi-implicit: s sub-steps fall (1 + 1 / s) times the
// parabola.
template <class T>
T fall_in_step(const StepSettings<T>& settings) noexcept {
  return T(0.5) * (T(1) + T(1) / static_cast<T>(settings.sub_steps)) * norm(settings.gravity) * settings.dt *
         settings.dt;
}

// How near a body must be to a fixed one to be compared with it [m].
template <class T>
T margin_to_fixed(const Reach<T>& reach, const StepSettings<T>& settings) noexcept {
  const T closing = std::min(reach.moved + reach.fallen, settings.max_margin);
  return std::max(settings.min_margin, closing + room_to_carry_over(settings));
}

// By how much a body's bounds grow [m]: those of two grow by at least the margin of their pair. Two bodies fall side by
// side, or one of them is held, so each takes half of the fall, and half of the room. `fall`: fall_in_step.
template <class T>
T growth_of(const Reach<T>& reach, T fall, const StepSettings<T>& settings) noexcept {
  const T heavier = std::max(reach.fallen - fall, T(0));
  const T closing = std::min(reach.moved + T(0.5) * fall + heavier, settings.max_margin);
  return T(0.5) * room_to_carry_over(settings) + std::max(T(0.5) * settings.min_margin, closing);
}

// By how much bounds that have grown so are short of margin_to_fixed [m, at most].
template <class T>
T growth_to_fixed(T fall, const StepSettings<T>& settings) noexcept {
  return std::max(T(0.5) * settings.min_margin, T(0.5) * (fall + room_to_carry_over(settings)));
}

// A pose that is no pose: of a body that the last step did not know.
template <class T>
constexpr Pose<T> unknown_pose() noexcept {
  constexpr T nan = std::numeric_limits<T>::quiet_NaN();
  return {{nan, nan, nan}, {nan, nan, nan, nan}};
}

// Fills `shift`, `turned` and `slack`. What comes of them is subtracted from distances of at most `far` [m], over many
// steps: the slack of what has moved covers what such a difference may lose to rounding too.
template <class T>
void measure_motion(const Pose<T>& before, const Pose<T>& now, T far, Reach<T>& reach) noexcept {
  // Unit quaternions: |q - p| = 2 sin(angle / 4), and no axis turns by more than twice that. Of a quaternion and its
  // negative, the same rotation, this says much too much, which only costs time.
  const Quat<T>&p = before.rotation, &q = now.rotation;
  const T dw = q.w - p.w, dx = q.x - p.x, dy = q.y - p.y, dz = q.z - p.z;
  const Vec3<T> shift = now.position - before.position;
  const T shifted = norm(shift);
  const T turned = T(2) * std::sqrt(dw * dw + dx * dx + dy * dy + dz * dz);
  constexpr T unknown = std::numeric_limits<T>::infinity(), rounding = T(2) * std::numeric_limits<T>::epsilon();
  reach.shift = {}, reach.turned = reach.slack = T(0);
  if (shifted == T(0) && turned == T(0)) return;
  if (!(shifted < unknown && turned < unknown)) {  // a NaN too
    reach.slack = unknown;
    return;
  }
  reach.shift = shift;
  reach.turned = turned * (T(1) + T(8) * rounding);
  reach.slack = T(4) * rounding * shifted + rounding * far;
}

}  // namespace tactus::physics
