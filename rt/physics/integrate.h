// Integrates the free motion of a body over one sub-step: the rotation with its gyroscopic term.
//
// Frame: world; inertia diagonal in the body frame. Units: SI. Thread: [any], pure. Bound: 4 fixed-point iterations,
// each of which reduces the error by a factor h |w| (1 - I_min / I_max); for h |w| < 0.5. A body that turns more in a
// sub-step is turned at constant angular velocity: the energy is kept, the direction of the angular momentum is not.
#pragma once

#include <span>

#include "rt/base/spatial.h"
#include "rt/physics/body.h"
#include "rt/physics/solver_body.h"

namespace tactus::physics {

// Rotation and angular velocity at the end of a sub-step.
template <class T>
struct FreeRotation {
  Quat<T> change;            // end_from_start, world axes
  Vec3<T> angular_velocity;  // rad/s, world
};

// The gyroscopic term by implicit midpoint in the body frame: I (w1 - w0) + h m x I m = 0, m = (w0 + w1) / 2, and the
// rotation by the Cayley map of h m. The midpoint rule keeps the energy. With the Cayley map (not with the exponential
// map) the same equation also keeps the angular momentum in the world:
// (1 + h m x / 2) I w1 = (1 - h m x / 2) I w0.
template <class T>
FreeRotation<T> rotate_freely(const Quat<T>& world_from_body, const Vec3<T>& angular_velocity, const Vec3<T>& inertia,
                              T h) noexcept;

// For a body with equal principal inertias, or with the gyroscopic term left out: the angular velocity stays, the
// rotation is the exponential map of h w.
template <class T>
FreeRotation<T> rotate_steadily(const Vec3<T>& angular_velocity, T h) noexcept;

// Integrates positions and rotations over a sub-step, several bodies at once where all of them take the usual case.
// `bodies` and `motion`: by slot. Bound: linear in bodies.
template <class T>
void move_bodies(std::span<SolverBody<T>> motion, std::span<const Body> bodies, T h) noexcept;

// True if the inertia has a gyroscopic term.
template <class T>
constexpr bool is_anisotropic(const Vec3<T>& inertia) noexcept {
  const T low = inertia.x < inertia.y ? (inertia.x < inertia.z ? inertia.x : inertia.z)
                                      : (inertia.y < inertia.z ? inertia.y : inertia.z);
  const T high = inertia.x > inertia.y ? (inertia.x > inertia.z ? inertia.x : inertia.z)
                                       : (inertia.y > inertia.z ? inertia.y : inertia.z);
  return high - low > T(1e-6) * high;  // below: rounding error of an isotropic inertia
}

}  // namespace tactus::physics
