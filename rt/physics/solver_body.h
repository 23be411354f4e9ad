// The state of a body that the solver's sweeps read and write, packed: all that changes within a step and is read at
// every contact.
//
// Frame: world. Units: SI. 16 scalars, so 128 bytes in double: two whole cache lines. The inverse inertia, constant
// over a step, is in an array of its own, because integration does not read it. Thread: the owner of the World [rt].
#pragma once

#include <cmath>
#include <span>

#include "rt/base/bounded_vector.h"
#include "rt/physics/body.h"

namespace tactus::physics {

template <class T>
struct alignas(16 * sizeof(T)) SolverBody {
  Vec3<T> v, w;            // m/s, rad/s
  Vec3<T> delta_position;  // m, since the start of the step
  Quat<T> delta_rotation;  // now_from_start, world axes
  T inverse_mass{};        // 1/kg; 0: infinite mass
  T gyroscopic{};          // 1: has a gyroscopic term, else 0
  T fill{};
};
static_assert(sizeof(SolverBody<double>) == 128 && sizeof(SolverBody<float>) == 64);

template <class To, class T>
SolverBody<To> number_cast(const SolverBody<T>& body) noexcept {
  return {number_cast<To>(body.v),
          number_cast<To>(body.w),
          number_cast<To>(body.delta_position),
          number_cast<To>(body.delta_rotation),
          static_cast<To>(body.inverse_mass),
          static_cast<To>(body.gyroscopic),
          To(0)};
}

// The dynamic bodies of one step, by slot. Fixed bodies have no entry: their rows leave that side out.
template <class T>
struct SolverBodies {
  std::span<SolverBody<T>> motion;
  std::span<const SymMat3<T>> inverse_inertia;  // 1/(kg m^2), world, at the start of the step
};

// Applies the impulse `p` [N s] at `r` [m] from the centre.
template <class T>
void apply_impulse_at(SolverBody<T>& body, const SymMat3<T>& inverse_inertia, const Vec3<T>& r,
                      const Vec3<T>& p) noexcept {
  body.v += body.inverse_mass * p;
  body.w += inverse_inertia * cross(r, p);
}

template <class T>
Vec3<T> velocity_at(const SolverBody<T>& body, const Vec3<T>& r) noexcept {
  return body.v + cross(body.w, r);
}

// Change of velocity along d2 per unit impulse along d1, both at r: an entry of J M^-1 J^T.
template <class T>
T inverse_effective_mass(T inverse_mass, const SymMat3<T>& inverse_inertia, const Vec3<T>& r, const Vec3<T>& d1,
                         const Vec3<T>& d2) noexcept {
  return inverse_mass * dot(d1, d2) + dot(inverse_inertia * cross(r, d1), cross(r, d2));
}

template <class T>
T invert_or_zero(T value) noexcept {
  return select(value > T(0), T(1) / value, T(0));
}

// One effective mass for both tangents: the inverse of the larger eigenvalue of the 2 x 2 matrix. A step of that size,
// clamped to the Coulomb disk, never raises the kinetic energy, and where it stops sliding, friction is opposite to the
// slip; the inverse of the matrix guarantees neither.
template <class T>
T tangent_mass_of(T k11, T k22, T k12) noexcept {
  using std::sqrt;
  const T mean = T(0.5) * (k11 + k22), half = T(0.5) * (k11 - k22);
  return invert_or_zero(mean + sqrt(half * half + k12 * k12));
}

// Clamps the vector (x, y) to the length `radius`.
template <class T>
void clamp_to_disk(T& x, T& y, T radius) noexcept {
  using std::sqrt;
  const T length_squared = x * x + y * y;
  const T s = select(length_squared > radius * radius, radius / sqrt(length_squared), T(1));
  x *= s;
  y *= s;
}

}  // namespace tactus::physics
