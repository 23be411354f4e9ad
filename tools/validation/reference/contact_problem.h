// A contact problem with exact Coulomb friction, at one instant: which impulses bring the velocities v0 into agreement
// with the contacts? And two solvers that have nothing in common, so that each is the other's witness.
//
// v = v0 + M^-1 J^T lambda; rows of J by contact: normal (from A to B), two tangents. Per contact, u = J v + bias n:
//   0 <= lambda_n and u_n >= 0, one of them 0;  |lambda_t| <= mu lambda_n, and where u_t is not 0 lambda_t is
//   -mu lambda_n u_t / |u_t|.
// Equivalently, with Gamma(u) = (mu |u_t|, 0, 0): K* holds u + Gamma(u), K holds lambda, and they are orthogonal.
// Impulses of redundant contacts are not unique; the net wrench of a body is what two solutions have in common.
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
  Eigen::VectorXd bias;  // m/s, by contact: added to u_n (gap / h of one that is still open; 0 of one that touches)

  Eigen::Index contacts() const { return friction.size(); }
  Eigen::Index bodies() const { return v0.size() / 6; }
};

struct Solution {
  Eigen::VectorXd impulse;  // N s, by row
  double residual{0};       // the largest of those below
  std::size_t iterations{0};
};

// How far `impulse` is from a solution, without a scale: the natural map's residual, |lambda - P_K(lambda - r (u +
// Gamma))| by the largest impulse, with r the inverse of the contact's own inertia, over all contacts.
double residual_of(const ContactProblem& problem, const Eigen::VectorXd& impulse);

// Body by body, J^T lambda [N s, N m s].
Eigen::VectorXd net_wrenches(const ContactProblem& problem, const Eigen::VectorXd& impulse);

// Block Gauss-Seidel: each contact's 3 x 3 problem exactly, the others held; over and over. Where the sweeps go
// straight on they are extrapolated (Aitken), at most to where a contact starts to slide.
Solution solve_gauss_seidel(const ContactProblem& problem, double residual, std::size_t most_iterations);

// Alternating directions (augmented Lagrangian): a linear solve for all rows at once, a projection on the cones, and
// Gamma taken from the last iterate. The penalty follows what is left of the residual.
Solution solve_admm(const ContactProblem& problem, double residual, std::size_t most_iterations);

// What the world was at the start of the step it has just made: velocities with gravity and the wrench-free forces of
// `dt`, the contacts as they were found, all as hard as can be.
ContactProblem dump(const physics::World& before, const physics::World& after, const Vec3d& gravity, double dt);

// As text, numbers to their last bit, and back. An error says what is wrong.
std::string to_text(const ContactProblem& problem);
Result<ContactProblem> from_text(const std::string& text);

}  // namespace tactus::reference
