#include "rt/physics/shapes/principal_axes.h"

#include <cmath>

namespace tactus::physics {

// Cyclic Jacobi with a fixed number of sweeps: it converges quadratically, six are enough for any 3 x 3 matrix.
// Off-diagonal entries at rounding level are left, so that a cube keeps its axes.
Principal principal_axes(const SymMat3d& m) noexcept {
  double a[3][3] = {{m.xx, m.xy, m.xz}, {m.xy, m.yy, m.yz}, {m.xz, m.yz, m.zz}};
  double v[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const double noise = 1e-9 * (m.xx + m.yy + m.zz);
  for (int sweep = 0; sweep < 8; ++sweep) {
    for (int p = 0; p < 2; ++p) {
      for (int q = p + 1; q < 3; ++q) {
        if (!(std::abs(a[p][q]) > (sweep == 0 ? noise : 1e-9 * noise))) continue;
        const double theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
        const double t = (theta < 0 ? -1 : 1) / (std::abs(theta) + std::sqrt(theta * theta + 1));
        const double c = 1 / std::sqrt(t * t + 1), s = t * c;
        for (int k = 0; k < 3; ++k) {
          const double kp = a[k][p], kq = a[k][q];
          a[k][p] = c * kp - s * kq;
          a[k][q] = s * kp + c * kq;
        }
        for (int k = 0; k < 3; ++k) {
          const double pk = a[p][k], qk = a[q][k];
          a[p][k] = c * pk - s * qk;
          a[q][k] = s * pk + c * qk;
        }
        for (int k = 0; k < 3; ++k) {
          const double kp = v[k][p], kq = v[k][q];
          v[k][p] = c * kp - s * kq;
          v[k][q] = s * kp + c * kq;
        }
      }
    }
    if (sweep == 0 && v[0][0] == 1 && v[1][1] == 1 && v[2][2] == 1) break;
  }
  Principal out;
  for (int k = 0; k < 3; ++k) {
    out.moment[k] = a[k][k];
    out.axis[k] = {v[0][k], v[1][k], v[2][k]};
  }
  out.axis[2] = cross(out.axis[0], out.axis[1]);
  return out;
}

}  // namespace tactus::physics
