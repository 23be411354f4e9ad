// Principal axes of a symmetric matrix, such as an inertia tensor. Thread: [setup]. Pure, no allocation.
#pragma once

#include "rt/base/spatial.h"

namespace tactus::physics {

struct Principal {
  double moment[3];  // the matrix along each axis
  Vec3d axis[3];     // unit, right-handed
};

// Source: cyclic Jacobi rotations (Golub and Van Loan, Matrix Computations, section 8.5).
Principal principal_axes(const SymMat3d& m) noexcept;

}  // namespace tactus::physics
