#include "rt/physics/integrate.h"

namespace tactus::physics {

template <class T>
FreeRotation<T> rotate_freely(const Quat<T>& world_from_body, const Vec3<T>& angular_velocity, const Vec3<T>& inertia,
                              T h) noexcept {
  const Vec3<T> w0 = rotate_inverse(world_from_body, angular_velocity);
  const Vec3<T> gain{h / inertia.x, h / inertia.y, h / inertia.z};
  Vec3<T> w1 = w0, mid = w0;
  for (int i = 0; i < 4; ++i) {
    w1 = w0 - scale(gain, cross(mid, scale(inertia, mid)));
    mid = T(0.5) * (w0 + w1);
  }
  const Vec3<T> half = rotate(world_from_body, T(0.5) * h * mid);
  const Quat<T> change = normalized(Quat<T>{T(1), half.x, half.y, half.z});
  return {change, rotate(change, rotate(world_from_body, w1))};
}

template <class T>
FreeRotation<T> rotate_steadily(const Vec3<T>& angular_velocity, T h) noexcept {
  const Vec3<T> v = h * angular_velocity;
  const T angle_squared = norm_squared(v);
  if (angle_squared < T(0.01)) {
    // Series of cos and sin(x)/x in x = angle / 2, to x^8: the first term left out is below 3e-20 here. The usual
    // case, and several times faster than the general one.
    const T x2 = T(0.25) * angle_squared;
    const T c = T(1) - x2 * (T(1.0 / 2) - x2 * (T(1.0 / 24) - x2 * (T(1.0 / 720) - x2 * T(1.0 / 40320))));
    const T s = T(1) - x2 * (T(1.0 / 6) - x2 * (T(1.0 / 120) - x2 * (T(1.0 / 5040) - x2 * T(1.0 / 362880))));
    const T k = T(0.5) * s;
    return {{c, k * v.x, k * v.y, k * v.z}, angular_velocity};
  }
  return {quat_from_rotation_vector(v), angular_velocity};
}

template FreeRotation<double> rotate_freely(const Quat<double>&, const Vec3<double>&, const Vec3<double>&,
                                            double) noexcept;
template FreeRotation<float> rotate_freely(const Quat<float>&, const Vec3<float>&, const Vec3<float>&, float) noexcept;
template FreeRotation<double> rotate_steadily(const Vec3<double>&, double) noexcept;
template FreeRotation<float> rotate_steadily(const Vec3<float>&, float) noexcept;

}  // namespace tactus::physics
