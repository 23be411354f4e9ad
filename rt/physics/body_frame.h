// A body's pose as narrow phase reads it: its centre, and its axes as unit vectors of the world.
//
// The rotation matrix is computed once per body and step, not once per pair. Frame: world. Units: m. Thread: [any].
#pragma once

#include "rt/base/spatial.h"

namespace tactus::physics {

// Columns of the rotation: the body's axes in the world.
struct Axes {
  Vec3d x, y, z;
};

constexpr Axes axes_of(const Quatd& q) noexcept {
  const double xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z, xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
  const double wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  return {{1.0 - 2.0 * (yy + zz), 2.0 * (xy + wz), 2.0 * (xz - wy)},
          {2.0 * (xy - wz), 1.0 - 2.0 * (xx + zz), 2.0 * (yz + wx)},
          {2.0 * (xz + wy), 2.0 * (yz - wx), 1.0 - 2.0 * (xx + yy)}};
}

struct BodyFrame {
  Vec3d position;  // m
  Axes axes;

  static constexpr BodyFrame of(const Posed& world_from_body) noexcept {
    return {world_from_body.position, axes_of(world_from_body.rotation)};
  }
};

}  // namespace tactus::physics
