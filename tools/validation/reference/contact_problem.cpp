#include "tools/validation/reference/contact_problem.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "tools/validation/reference/friction_cone.h"

namespace tactus::reference {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

Vector3d as_eigen(const Vec3d& v) { return {v.x, v.y, v.z}; }

Matrix3d inverse_inertia(const physics::Body& body) {
  const Quatd& q = body.motion.pose.rotation;
  const Matrix3d r = Eigen::Quaterniond(q.w, q.x, q.y, q.z).toRotationMatrix();
  return r * Vector3d(1 / body.inertia.x, 1 / body.inertia.y, 1 / body.inertia.z).asDiagonal() * r.transpose();
}

void put_row(MatrixXd& jacobian, Index row, std::uint32_t slot, const Vec3d& direction, const Vec3d& arm, double sign) {
  jacobian.block<1, 3>(row, 6 * slot) = sign * as_eigen(direction).transpose();
  jacobian.block<1, 3>(row, 6 * slot + 3) = sign * as_eigen(cross(arm, direction)).transpose();
}

void put(std::string& text, const char* name, const MatrixXd& m) {
  text += fmt::format("{} {} {}\n", name, m.rows(), m.cols());
  for (Index i = 0; i < m.rows(); ++i) {
    for (Index j = 0; j < m.cols(); ++j) text += fmt::format("{}{}", j > 0 ? " " : "", m(i, j));
    text += '\n';
  }
}

bool get(std::istream& in, const std::string& name, MatrixXd& m) {
  std::string word;
  Index rows = 0, columns = 0;
  if (!(in >> word >> rows >> columns) || word != name || rows < 0 || columns < 0 || rows * columns > 4'000'000)
    return false;
  m.resize(rows, columns);
  for (Index i = 0; i < rows; ++i)
    for (Index j = 0; j < columns; ++j)
      if (!(in >> m(i, j))) return false;
  return true;
}

}  // namespace

double residual_of(const ContactProblem& p, const VectorXd& impulse) {
  const MatrixXd delassus = p.jacobian * p.inverse_mass * p.jacobian.transpose();
  const VectorXd u = p.jacobian * p.v0 + delassus * impulse;
  double worst = 0, largest = 0;
  for (Index c = 0; c < p.contacts(); ++c) {
    const Vector3d lambda = impulse.segment<3>(3 * c);
    Vector3d velocity = u.segment<3>(3 * c);
    velocity[0] += p.bias[c] + p.friction[c] * velocity.tail<2>().norm();
    const double mass = 1 / delassus.block<3, 3>(3 * c, 3 * c).trace();
    worst = std::max(worst, (lambda - project_on_cone(lambda - mass * velocity, p.friction[c])).norm());
    largest = std::max(largest, lambda.norm());
  }
  return largest > 0 ? worst / largest : worst;
}

VectorXd net_wrenches(const ContactProblem& p, const VectorXd& impulse) { return p.jacobian.transpose() * impulse; }

ContactProblem dump(const physics::World& before, const physics::World& after, const Vec3d& gravity, double dt) {
  const auto bodies = before.bodies();
  const auto count = static_cast<Index>(bodies.size());
  ContactProblem p;
  p.inverse_mass = MatrixXd::Zero(6 * count, 6 * count);
  p.v0 = VectorXd::Zero(6 * count);
  for (Index i = 0; i < count; ++i) {
    const auto& body = bodies[static_cast<std::size_t>(i)];
    p.inverse_mass.block<3, 3>(6 * i, 6 * i) = Matrix3d::Identity() / body.mass;
    p.inverse_mass.block<3, 3>(6 * i + 3, 6 * i + 3) = inverse_inertia(body);
    p.v0.segment<3>(6 * i) = as_eigen(body.motion.velocity.linear + (body.gravity_scale * dt) * gravity);
    p.v0.segment<3>(6 * i + 3) = as_eigen(body.motion.velocity.angular);
  }
  Index points = 0;
  for (const auto& contact : after.contacts()) points += contact.count;
  p.jacobian = MatrixXd::Zero(3 * points, 6 * count);
  p.friction.resize(points);
  p.bias.resize(points);
  Index row = 0;
  for (const auto& contact : after.contacts()) {
    const auto [t1, t2] = tangents_of(contact.normal);
    for (std::uint32_t k = 0; k < contact.count; ++k, ++row) {
      const auto& point = contact.points[k];
      p.friction[row] = contact.friction;
      p.bias[row] = std::max(0.0, point.separation) / dt;
      const Vec3d directions[3] = {contact.normal, t1, t2};
      for (int d = 0; d < 3; ++d) {
        put_row(p.jacobian, 3 * row + d, contact.slot_a, directions[d], point.from_a, -1);
        if (!contact.b_fixed) put_row(p.jacobian, 3 * row + d, contact.slot_b, directions[d], point.from_b, 1);
      }
    }
  }
  return p;
}

std::string to_text(const ContactProblem& p) {
  std::string text = "tactus contact problem 1\n";
  put(text, "inverse_mass", p.inverse_mass);
  put(text, "jacobian", p.jacobian);
  put(text, "v0", p.v0);
  put(text, "friction", p.friction);
  put(text, "bias", p.bias);
  return text;
}

Result<ContactProblem> from_text(const std::string& text) {
  std::istringstream in(text);
  std::string line;
  if (!std::getline(in, line) || line != "tactus contact problem 1")
    return Status::error("no contact problem: its first line must be 'tactus contact problem 1'");
  ContactProblem p;
  MatrixXd v0, friction, bias;
  if (!get(in, "inverse_mass", p.inverse_mass) || !get(in, "jacobian", p.jacobian) || !get(in, "v0", v0) ||
      !get(in, "friction", friction) || !get(in, "bias", bias))
    return Status::error("contact problem: it ends before inverse_mass, jacobian, v0, friction and bias are there");
  if (p.inverse_mass.rows() != v0.rows() || p.inverse_mass.cols() != v0.rows() || p.jacobian.cols() != v0.rows() ||
      p.jacobian.rows() != 3 * friction.rows() || bias.rows() != friction.rows() || v0.rows() % 6 != 0)
    return Status::error("contact problem: its sizes do not go together");
  p.v0 = v0;
  p.friction = friction;
  p.bias = bias;
  return p;
}

}  // namespace tactus::reference
