// Where a body is, as narrow phase reads it: its centre and its axes as vectors of the world.
//
// A rotation matrix is worked out once a step and body, not once a pair. Frame: world. Units: m. Thread: [any].
#pragma once

#include "rt/base/spatial.h"

namespace tactus::physics {

// Columns of the rotation: the body's axes in the world.
template <class T>
struct Axes {
  Vec3<T> x, y, z;
};

template <class T>
constexpr Axes<T> axes_of(const Quat<T>& q) noexcept {
  const T xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
  const T wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  return {{T(1) - T(2) * (yy + zz), T(2) * (xy + wz), T(2) * (xz - wy)},
          {T(2) * (xy - wz), T(1) - T(2) * (xx + zz), T(2) * (yz + wx)},
          {T(2) * (xz + wy), T(2) * (yz - wx), T(1) - T(2) * (xx + yy)}};
}

template <class T>
struct BodyFrame {
  Vec3<T> position;  // m
  Axes<T> axes;

  static constexpr BodyFrame of(const Pose<T>& world_from_body) noexcept {
    return {world_from_body.position, axes_of(world_from_body.rotation)};
  }
};

}  // namespace tactus::physics
