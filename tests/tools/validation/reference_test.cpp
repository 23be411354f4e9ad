// The reference: two methods with nothing in common agree on every stored problem, each to 1e-10; and both agree with
// what mechanics says where it says it in a line.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "tools/validation/case_world.h"
#include "tools/validation/reference/contact_problem.h"
#include "tools/validation/reference/friction_cone.h"

using namespace tactus;
using namespace tactus::reference;
using namespace tactus::hard_cases;

namespace {

constexpr double kResidual = 1e-10, kAgreement = 1e-6;
constexpr std::size_t kMax = 100'000;

// A point of `mass` on the ground, with velocity `v`: the frame's axes are normal, t1, t2.
ContactProblem point_on_ground(double mass, const Eigen::Vector3d& v, double mu) {
  ContactProblem p;
  p.inverse_mass = Eigen::MatrixXd::Identity(6, 6) / mass;
  p.jacobian = Eigen::MatrixXd::Zero(3, 6);
  p.jacobian.block<3, 3>(0, 0) = Eigen::Matrix3d::Identity();
  p.v0 = Eigen::VectorXd::Zero(6);
  p.v0.head<3>() = v;
  p.friction = Eigen::VectorXd::Constant(1, mu);
  p.bias = Eigen::VectorXd::Zero(1);
  return p;
}

// The bodies whose net wrench the contact laws determine. A body that turns while it slides on more than three points
// is none: its load can be shared among them in more than one way, and each share has another friction.
std::vector<Eigen::Index> determined_bodies(const ContactProblem& p, const Solution& solution) {
  const Eigen::VectorXd u = p.jacobian * (p.v0 + p.inverse_mass * p.jacobian.transpose() * solution.impulse);
  std::vector<Eigen::Index> bodies;
  for (Eigen::Index body = 0; body < p.bodies(); ++body) {
    double sliding = 0;
    Eigen::Vector2d directions = Eigen::Vector2d::Zero();  // their sum; as long as their number if all are one
    for (Eigen::Index c = 0; c < p.contacts(); ++c) {
      const Eigen::Vector2d u_t = u.segment<2>(3 * c + 1);
      const bool touches = !p.jacobian.block<3, 6>(3 * c, 6 * body).isZero() && solution.impulse[3 * c] > 0;
      if (!touches || u_t.norm() < 1e-6) continue;
      sliding += 1;
      directions += u_t.normalized();
    }
    if (sliding <= 3 || directions.norm() > sliding - 1e-9) bodies.push_back(body);
  }
  return bodies;
}

// Largest relative difference of a determined body's net wrench.
double disagreement(const ContactProblem& p, const Solution& a, const Solution& b) {
  const Eigen::VectorXd of_a = net_wrenches(p, a.impulse), of_b = net_wrenches(p, b.impulse);
  double worst = 0;
  for (const Eigen::Index body : determined_bodies(p, a)) {
    const double scale = std::max(of_a.segment<6>(6 * body).norm(), of_a.norm() / std::sqrt(double(p.bodies())));
    worst = std::max(worst, (of_a - of_b).segment<6>(6 * body).norm() / scale);
  }
  return worst;
}

struct Scenario {
  const char* name;
  double run_s;
  void (*fill)(CaseWorld&);
};

// What problems are taken from: the step after `run_s`.
const Scenario kScenarios[] = {
    {"stack_of_four", 0.5,
     [](CaseWorld& world) {
       world.add_ground(kGround, 0.5);
       for (BodyId id = 0; id < 4; ++id) world.add_box(id, {0.05, 0.05, 0.05}, 1, 0.5, {{0, 0, 0.05 + 0.1 * id}, {}});
     }},
    {"ball_on_a_stack", 0.021,
     [](CaseWorld& world) {
       world.add_ground(kGround, 0.5);
       for (BodyId id = 0; id < 3; ++id) world.add_box(id, {0.05, 0.05, 0.05}, 1, 0.5, {{0, 0, 0.05 + 0.1 * id}, {}});
       world.add_sphere(3, 0.03, 1, 0.5, {0.01, 0, 0.43}, {0.3, 0, -5});
     }},
    {"sliding_box", 0.1,
     [](CaseWorld& world) {
       world.add_ground(kGround, 0.3);
       world.add_box(
           0, {0.05, 0.04, 0.03}, 1, 0.3, {{0, 0, 0.03}, {}},
           {{2, 0.5, 0}, {}});  // it does not turn: or else friction has as many answers as the load on four points
     }},
    {"leaning_boxes", 0.3,
     [](CaseWorld& world) {
       world.add_ground(kGround, 0.6);
       world.add_box(0, {0.01, 0.04, 0.1}, 0.3, 0.6, {{-0.035, 0, 0.099}, quat_from_rotation_vector(Vec3d{0, 0.3, 0})});
       world.add_box(1, {0.01, 0.04, 0.1}, 0.3, 0.6, {{0.035, 0, 0.099}, quat_from_rotation_vector(Vec3d{0, -0.3, 0})});
     }},
    {"ratio_of_a_hundred", 0.3,
     [](CaseWorld& world) {
       world.add_ground(kGround, 0.5);
       world.add_box(0, {0.05, 0.05, 0.05}, 1, 0.5, {{0, 0, 0.05}, {}});
       world.add_box(1, {0.05, 0.05, 0.05}, 100, 0.5, {{0, 0, 0.15}, {}});
     }},
    {"heap", 0.4,
     [](CaseWorld& world) {
       world.add_ground(kGround, 0.8);
       for (BodyId id = 0; id < 8; ++id)
         world.add_box(id, {0.03, 0.02, 0.04}, 0.2, 0.5,
                       {{0.06 * (id % 2), 0.05 * (id / 2 % 2), 0.06 + 0.09 * (id / 4)},
                        quat_from_rotation_vector(Vec3d{0.3 * id, 0.7, 0.2 * id})},
                       {{0.2, 0, -1}, {5, 0, 3}});
     }},
};

ContactProblem problem_of(const Scenario& scenario) {
  CaseWorld world({Accuracy::kAccurate, 1e-3});
  scenario.fill(world);
  world.run(scenario.run_s);
  physics::World before({});
  for (const auto& body : world.world.bodies()) REQUIRE(before.insert(body));
  world.step();
  return dump(before, world.world, world.settings.gravity, world.settings.dt);
}

std::string data_file(const std::string& name) {
  return std::string(TACTUS_SOURCE_DIR "/tests/tools/validation/data/") + name + ".txt";
}

ContactProblem stored(const std::string& name) {
  std::ifstream file(data_file(name));
  std::stringstream text;
  text << file.rdbuf();
  auto problem = from_text(text.str());
  INFO(name << ": " << problem.message());
  REQUIRE(problem.ok());
  return std::move(problem).value();
}

}  // namespace

TEST_CASE("a point that meets the ground sticks within the cone, slides at its edge, and leaves untouched") {
  const double m = 0.5, mu = 0.4;
  for (const bool admm : {false, true}) {
    const auto solve = [&](const Eigen::Vector3d& v) {
      const ContactProblem p = point_on_ground(m, v, mu);
      const Solution s = admm ? solve_admm(p, 1e-13, kMax) : solve_gauss_seidel(p, 1e-13, kMax);
      return Eigen::Vector3d(s.impulse);
    };
    CHECK((solve({-1, 0.3, 0.2}) - m * Eigen::Vector3d(1, -0.3, -0.2)).norm() < 1e-10);
    // Faster than mu times the approach: |lambda_t| = mu lambda_n, against the motion.
    CHECK((solve({-1, 0.6, 0.8}) - m * Eigen::Vector3d(1, -0.6 * mu, -0.8 * mu)).norm() < 1e-10);
    CHECK(solve({0.1, 0.6, 0.8}).norm() < 1e-10);
  }
}

TEST_CASE("one contact's problem is solved exactly whatever its matrix: complementarity, cone, direction") {
  std::uint64_t state = 1;
  const auto number = [&state] {
    state = state * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<double>(state >> 11) / 4503599627370496.0 - 1;
  };
  int sliding = 0;
  for (int n = 0; n < 2000; ++n) {
    Eigen::Matrix3d a;
    for (int k = 0; k < 9; ++k) a(k / 3, k % 3) = number();
    const Eigen::Matrix3d w = a * a.transpose() + 0.05 * Eigen::Matrix3d::Identity();
    const Eigen::Vector3d b{number(), number(), number()};
    const double mu = 0.5 * (number() + 1);
    const Eigen::Vector3d x = solve_one_contact(w, b, mu), u = w * x + b;
    const double t = x.tail<2>().norm();
    REQUIRE(x[0] >= 0);
    REQUIRE(u[0] >= -1e-9);
    REQUIRE(std::abs(x[0] * u[0]) < 1e-9);
    REQUIRE(t <= mu * x[0] + 1e-9);
    if (x[0] > 1e-6 && u.tail<2>().norm() > 1e-6) {
      ++sliding;
      REQUIRE(std::abs(t - mu * x[0]) < 1e-7);
      REQUIRE(u.tail<2>().dot(x.tail<2>()) <= 0);
      REQUIRE(std::abs(u[1] * x[2] - u[2] * x[1]) < 1e-7);
    }
  }
  CHECK(sliding > 100);
}

TEST_CASE("both methods solve every stored problem to 1e-10 and agree on each determined net wrench to 1e-6") {
  for (const Scenario& scenario : kScenarios) {
    const ContactProblem problem = stored(scenario.name);
    const Solution a = solve_gauss_seidel(problem, kResidual, kMax), b = solve_admm(problem, kResidual, kMax);
    INFO(scenario.name << ": " << problem.contacts() << " contacts, " << a.iterations << " sweeps, " << b.iterations
                       << " steps, residuals " << a.residual << " and " << b.residual);
    CHECK(a.residual <= kResidual);
    CHECK(b.residual <= kResidual);
    CHECK(disagreement(problem, a, b) < kAgreement);
    CHECK(determined_bodies(problem, a).size() == std::size_t(problem.bodies()));
  }
}

TEST_CASE("a stored problem is the one that the world gives today, and text gives it back to the last bit") {
  for (const Scenario& scenario : kScenarios) {
    INFO(scenario.name);
    const ContactProblem now = problem_of(scenario), then = stored(scenario.name);
    CHECK(now.contacts() == then.contacts());
    auto again = from_text(to_text(now));
    REQUIRE(again.ok());
    CHECK(again.value().jacobian == now.jacobian);
    CHECK(again.value().v0 == now.v0);
  }
  CHECK_FALSE(from_text("tactus contact problem 1\ninverse_mass 6 6\n1 2 3").ok());
  CHECK_FALSE(from_text("something else").ok());
}

TEST_CASE("a resting stack's step has the reference's net wrenches") {
  const ContactProblem problem = stored("stack_of_four");
  const Solution s = solve_gauss_seidel(problem, kResidual, kMax);
  const Eigen::VectorXd wrench = net_wrenches(problem, s.impulse);
  for (Eigen::Index body = 0; body < problem.bodies(); ++body) {
    CHECK(wrench[6 * body + 2] == Approx(kGravity * 1e-3).epsilon(1e-4));  // m g dt
    CHECK(wrench.segment<3>(6 * body + 3).norm() < 1e-6);
  }
}

TEST_CASE("writes the stored problems again", "[.store]") {
  for (const Scenario& scenario : kScenarios) std::ofstream(data_file(scenario.name)) << to_text(problem_of(scenario));
  CHECK(std::filesystem::exists(data_file(kScenarios[0].name)));
}
