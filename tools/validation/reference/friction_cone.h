// Coulomb's cone K = {(n, t): |t| <= mu n} and the operations on it that both solvers use. Pure functions. Thread:
// [any].
#pragma once

#include <Eigen/Dense>
#include <cmath>

namespace tactus::reference {

// The nearest point of K.
inline Eigen::Vector3d project_on_cone(const Eigen::Vector3d& x, double mu) {
  const double t = x.tail<2>().norm();
  if (t <= mu * x[0]) return x;
  if (mu * t <= -x[0]) return Eigen::Vector3d::Zero();
  const double n = (x[0] + mu * t) / (1 + mu * mu);
  const double scale = t > 0 ? mu * n / t : 0;
  return {n, scale * x[1], scale * x[2]};
}

// Exact solution for one contact: W lambda + b = u with Signorini's and Coulomb's laws. W symmetric positive
// definite.
Eigen::Vector3d solve_one_contact(const Eigen::Matrix3d& w, const Eigen::Vector3d& b, double mu);

}  // namespace tactus::reference
