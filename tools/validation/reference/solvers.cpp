// The two solvers. They share only the cone and the residual.
#include <algorithm>
#include <cmath>
#include <limits>

#include "tools/validation/reference/contact_problem.h"
#include "tools/validation/reference/friction_cone.h"

namespace tactus::reference {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

constexpr std::size_t kLookEvery = 20;  // iterations between two evaluations of the residual
// ADMM, on rows scaled to unit diagonal.
constexpr double kProximal = 1e-9, kRelaxation = 1.6, kFirstPenalty = 0.1, kMaxUnbalanced = 10;
// Near the solution the iteration may stall: more than half of the residual is left after ten evaluations, because each
// step changes lambda by only residual / penalty. Then the penalty is reduced. If the residual grows a hundredfold, the
// reduction is undone.
constexpr double kNear = 1e-6, kStalled = 0.5, kLooser = 0.1, kRunsAway = 100;
// Gauss-Seidel extrapolates if two consecutive changes are parallel within this relative tolerance.
constexpr double kStraight = 0.1;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

// Largest multiple of `change` that can be added to `lambda` until the first sticking contact reaches its cone's
// boundary.
double way_to_the_edge(const ContactProblem& p, const VectorXd& lambda, const VectorXd& change) {
  double way = kInfinite;
  for (Index c = 0; c < p.contacts(); ++c) {
    const double mu = p.friction[c], n = lambda[3 * c], dn = change[3 * c];
    const Vector2d t = lambda.segment<2>(3 * c + 1), dt = change.segment<2>(3 * c + 1);
    // |t + s dt|^2 = mu^2 (n + s dn)^2
    const double inside = mu * mu * n * n - t.squaredNorm();
    if (inside <= 1e-9 * t.squaredNorm()) continue;  // at rest or sliding
    const double a = dt.squaredNorm() - mu * mu * dn * dn, b = t.dot(dt) - mu * mu * n * dn;
    const double root = std::sqrt(std::max(0.0, b * b + a * inside));
    if (b + root > 0) way = std::min(way, inside / (b + root));
  }
  return way;
}

// Extrapolates sweeps whose changes are parallel, each `rho` times the last: adds the rest of the geometric series, but
// only up to the point where a contact starts to slide, because the direction changes there. (With redundant contacts
// on a body the impulses may change by as little as 1e-12 N s per sweep, all in one direction, until a contact slides.)
class Leap {
 public:
  // Called at every evaluation of the residual.
  void take(const ContactProblem& p, VectorXd& lambda) {
    const VectorXd change = lambda - last_;
    const double rho = change.dot(change_) / change_.squaredNorm();
    const bool straight = rho > 0 && (change - rho * change_).norm() < kStraight * change.norm();
    const double way =
        straight ? std::min(rho < 1 ? rho / (1 - rho) : kInfinite, way_to_the_edge(p, lambda, change)) : kInfinite;
    change_ = change;
    if (std::isfinite(way)) {
      lambda += way * change;
      for (Index c = 0; c < p.contacts(); ++c)
        lambda.segment<3>(3 * c) = project_on_cone(lambda.segment<3>(3 * c), p.friction[c]);
      change_.setZero();
    }
    last_ = lambda;
  }

  explicit Leap(const VectorXd& start) : last_(start), change_(VectorXd::Zero(start.size())) {}

 private:
  VectorXd last_, change_;
};

}  // namespace

// With u_n = 0 the normal impulse follows from the tangential one, which leaves u_t = r + V t. A sliding contact has
// u_t = -k t with k > 0, so t(k) = -(V + k)^-1 r: from sticking at k = 0 to no friction at infinity, and for some k
// between, |t| is mu times the normal impulse.
Vector3d solve_one_contact(const Matrix3d& w, const Vector3d& b, double mu) {
  if (b[0] >= 0) return Vector3d::Zero();
  const Vector3d stuck = -w.ldlt().solve(b);
  if (stuck.tail<2>().norm() <= mu * stuck[0]) return stuck;
  const Vector2d w_tn = w.block<2, 1>(1, 0);
  const Matrix2d v = w.block<2, 2>(1, 1) - w_tn * w_tn.transpose() / w(0, 0);
  const Vector2d r = b.tail<2>() - w_tn * (b[0] / w(0, 0));
  const auto at = [&](double k) -> Vector3d {
    const Vector2d t = -(v + k * Matrix2d::Identity()).inverse() * r;
    return {-(b[0] + w_tn.dot(t)) / w(0, 0), t[0], t[1]};
  };
  const auto excess = [&](const Vector3d& x) { return x.tail<2>().norm() - mu * x[0]; };
  double low = 0, high = v.trace();
  while (excess(at(high)) > 0 && high < 1e30) {
    low = high;
    high *= 4;
  }
  for (int i = 0; i < 200 && high - low > 1e-16 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (excess(at(middle)) > 0 ? low : high) = middle;
  }
  return project_on_cone(at(0.5 * (low + high)), mu);
}

Solution solve_gauss_seidel(const ContactProblem& p, double residual, std::size_t most_iterations) {
  const MatrixXd w = p.jacobian * p.inverse_mass * p.jacobian.transpose();
  VectorXd free = p.jacobian * p.v0;
  for (Index c = 0; c < p.contacts(); ++c) free[3 * c] += p.bias[c];
  Solution solution;
  solution.impulse = VectorXd::Zero(free.size());
  VectorXd& lambda = solution.impulse;
  Leap leap(lambda);
  while (solution.iterations < most_iterations) {
    for (Index c = 0; c < p.contacts(); ++c) {
      const Matrix3d own = w.block<3, 3>(3 * c, 3 * c);
      const Vector3d u = free.segment<3>(3 * c) + w.middleRows<3>(3 * c) * lambda;
      lambda.segment<3>(3 * c) = solve_one_contact(own, u - own * lambda.segment<3>(3 * c), p.friction[c]);
    }
    if (++solution.iterations % kLookEvery != 0) continue;
    solution.residual = residual_of(p, lambda);
    if (solution.residual <= residual) break;
    leap.take(p, lambda);
  }
  solution.residual = residual_of(p, lambda);
  return solution;
}

Solution solve_admm(const ContactProblem& p, double residual, std::size_t most_iterations) {
  const Index contacts = p.contacts(), rows = 3 * contacts;
  MatrixXd w = p.jacobian * p.inverse_mass * p.jacobian.transpose();
  VectorXd free = p.jacobian * p.v0;
  // One scale per contact, so that the cone is unchanged.
  VectorXd scale(rows);
  for (Index c = 0; c < contacts; ++c) {
    free[3 * c] += p.bias[c];
    scale.segment<3>(3 * c).setConstant(1 / std::sqrt(w.block<3, 3>(3 * c, 3 * c).trace() / 3));
  }
  w = scale.asDiagonal() * w * scale.asDiagonal();
  free = scale.asDiagonal() * free;
  double penalty = kFirstPenalty;
  Eigen::LLT<MatrixXd> factor;
  const auto renew = [&] { factor.compute(w + (penalty + kProximal) * MatrixXd::Identity(rows, rows)); };
  renew();
  VectorXd x = VectorXd::Zero(rows), z = x, y = x, gamma = x, kept_z = x, kept_y = x;
  double residual_before = std::numeric_limits<double>::infinity();
  Solution solution;
  while (solution.iterations < most_iterations) {
    x = factor.solve(penalty * z - y - free - gamma + kProximal * x).eval();
    const VectorXd relaxed = kRelaxation * x + (1 - kRelaxation) * z, last = z;
    for (Index c = 0; c < contacts; ++c)
      z.segment<3>(3 * c) = project_on_cone(relaxed.segment<3>(3 * c) + y.segment<3>(3 * c) / penalty, p.friction[c]);
    y += penalty * (relaxed - z);
    // -y is the velocity u + Gamma, and Gamma has no tangential part.
    for (Index c = 0; c < contacts; ++c) gamma[3 * c] = p.friction[c] * y.segment<2>(3 * c + 1).norm();
    if (++solution.iterations % kLookEvery != 0) continue;
    solution.impulse = scale.asDiagonal() * z;
    solution.residual = residual_of(p, solution.impulse);
    if (solution.residual <= residual) break;
    if (solution.residual > kRunsAway * residual_before) {  // penalty too small for the contacts that slide now
      z = kept_z;
      y = kept_y;
      penalty /= kLooser;
      renew();
      continue;
    }
    if (solution.iterations % (10 * kLookEvery) != 0) continue;
    const double primal = (x - z).norm(), dual = penalty * (z - last).norm();
    const bool stalled = solution.residual > kStalled * residual_before && solution.residual < kNear;
    residual_before = solution.residual;
    kept_z = z;
    kept_y = y;
    if (stalled) {
      penalty *= kLooser;
      renew();
    } else if (primal > kMaxUnbalanced * dual) {
      penalty *= 3;
      renew();
    } else if (dual > kMaxUnbalanced * primal) {
      penalty /= 3;
      renew();
    }
  }
  solution.impulse = scale.asDiagonal() * z;
  solution.residual = residual_of(p, solution.impulse);
  return solution;
}

}  // namespace tactus::reference
