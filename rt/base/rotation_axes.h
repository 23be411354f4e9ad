// A rotation from its three axes. Thread: [any]. Source: Shepperd 1978.
#pragma once

#include "rt/base/spatial.h"

namespace tactus {

// Quaternion of the rotation whose matrix has these columns, of unit length and perpendicular; from the largest of its
// four components, so that no angle is singular.
inline Quatd quat_from_axes(const Vec3d& x, const Vec3d& y, const Vec3d& z) noexcept {
  const double four[4] = {1 + x.x + y.y + z.z, 1 + x.x - y.y - z.z, 1 - x.x + y.y - z.z, 1 - x.x - y.y + z.z};
  int largest = 0;
  for (int k = 1; k < 4; ++k)
    if (four[k] > four[largest]) largest = k;
  switch (largest) {
    case 0:
      return normalized(Quatd{four[0], y.z - z.y, z.x - x.z, x.y - y.x});
    case 1:
      return normalized(Quatd{y.z - z.y, four[1], x.y + y.x, z.x + x.z});
    case 2:
      return normalized(Quatd{z.x - x.z, x.y + y.x, four[2], y.z + z.y});
    default:
      return normalized(Quatd{x.y - y.x, z.x + x.z, y.z + z.y, four[3]});
  }
}

}  // namespace tactus
