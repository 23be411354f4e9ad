// A contact problem with exact Coulomb friction, at one instant: find the impulses that change the velocities v0 so
// that they satisfy the contact laws. Two solvers with different methods check each other.
//
// v = v0 + M^-1 J^T lambda; rows of J by contact: normal (from A to B), two tangents. Per contact, u = J v + bias n:
//   0 <= lambda_n and u_n >= 0, one of them 0;  |lambda_t| <= mu lambda_n, and if u_t is not 0,
//   lambda_t = -mu lambda_n u_t / |u_t|.
// Equivalently, with Gamma(u) = (mu |u_t|, 0, 0): u + Gamma(u) in K*, lambda in K, and the two are orthogonal.
// Impulses of redundant contacts are not unique. The net impulse on each body is, unless it turns while it slides on
// more than three points, so solutions are compared by it.
// Offline, double precision. Thread: [setup]. Units: SI. Source: De Saxce, Feng 1998 (bi-potential).
#pragma once

#include <Eigen/Dense>
#include <string>
#include <vector>

#include "rt/base/result.h"
#include "rt/physics/world.h"

namespace tactus::reference {

struct ContactProblem {
  Eigen::MatrixXd inverse_mass;  // 6 bodies x 6 bodies, block diagonal: linear, angular
  Eigen::MatrixXd jacobian;      // 3 contacts x 6 bodies
  Eigen::VectorXd v0;            // m/s, rad/s
  Eigen::VectorXd friction;      // by contact
  Eigen::VectorXd bias;          // m/s, by contact: added to u_n: gap / h if still open, 0 if touching

  Eigen::Index contacts() const { return friction.size(); }
  Eigen::Index bodies() const { return v0.size() / 6; }
};

struct Solution {
  Eigen::VectorXd impulse;  // N s, by row
  double residual{0};       // as residual_of()
  std::size_t iterations{0};
};

// Dimensionless distance of `impulse` from a solution: the residual of the natural map, |lambda - P_K(lambda - r (u +
// Gamma))| divided by the largest impulse, with r the inverse of the contact's effective mass; maximum over all
// contacts.
double residual_of(const ContactProblem& problem, const Eigen::VectorXd& impulse);

// Per body, J^T lambda [N s, N m s].
Eigen::VectorXd net_wrenches(const ContactProblem& problem, const Eigen::VectorXd& impulse);

// Block Gauss-Seidel: solves each contact's 3 x 3 problem exactly, with the others fixed, in repeated sweeps. If
// consecutive changes are parallel, they are extrapolated (Aitken), at most to the point where a contact starts to
// slide.
Solution solve_gauss_seidel(const ContactProblem& problem, double residual, std::size_t most_iterations);

// Alternating directions (augmented Lagrangian): a linear solve for all rows at once, a projection on the cones, and
// Gamma from the last iterate. The penalty adapts to the residual.
Solution solve_admm(const ContactProblem& problem, double residual, std::size_t most_iterations);

// The contact problem of the step that the world has just made: velocities including gravity over `dt`, the contacts
// found at its start, all rigid.
ContactProblem dump(const physics::World& before, const physics::World& after, const Vec3d& gravity, double dt);

// Conversion to text, with exact numbers, and back. Error: what is wrong with the text.
std::string to_text(const ContactProblem& problem);
Result<ContactProblem> from_text(const std::string& text);

}  // namespace tactus::reference
