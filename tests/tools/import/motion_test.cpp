// Imported mechanisms move as MuJoCo moves them; a stack and an incline as the formulas say.
#include <sstream>

#include "rt/physics/step.h"
#include "tactus/tactus.h"
#include "tests/tools/import/import_bench.h"
#include "tools/import/limited_process.h"

using namespace tactus;
using namespace tactus::test;

namespace {

constexpr double kGravity = 9.81;

// Centres of mass: rows every 10 ms, a column a body without the world.
using Path = std::vector<std::vector<Vec3d>>;

Path path_in_mujoco(const std::string& name, double seconds) {
  const auto text =
      scene_import::run_program({"node", (kModels / "motion.mjs").string(), compiler().parent_path().string(),
                                 (kModels / name).string(), fmt::format("{}", seconds)},
                                {});
  INFO(text.message());
  REQUIRE(text.ok());
  Path path;
  std::istringstream lines(text.value());
  for (std::string line; std::getline(lines, line);) {
    std::istringstream numbers(line);
    std::vector<Vec3d> row;
    for (Vec3d v; numbers >> v.x >> v.y >> v.z;) row.push_back(v);
    row.erase(row.begin());
    path.push_back(std::move(row));
  }
  return path;
}

// The centres of mass of the bodies of the scene after the proxy: what moves, in the model's order, then what is fixed.
// A tick is 1 / rate_Hz, of four sub-steps.
Path path_here(const std::string& name, double seconds, int rate_Hz = 1000) {
  const Scratch scratch;
  auto options = options_for(kModels / name);
  options.proxy_position = Vec3d{0, 5, 5};  // out of the way
  const auto file = written(imported(options), scratch);
  Options run;
  run.rate_Hz = rate_Hz;
  Session session;
  const Error error = session.open(file, run);
  INFO(error.message());
  REQUIRE_FALSE(error);
  Path path;
  for (int frame = 0; frame <= static_cast<int>(seconds * 100 + 0.5); ++frame) {
    std::vector<Vec3d> row;
    for (std::size_t i = 1; i < session.bodies().size(); ++i) {
      const BodyState& body = session.bodies()[i];
      const Vector3 centre = session.scene().body(static_cast<BodyNumber>(i)).centre_of_mass_m;
      const auto [w, x, y, z] = body.rotation;
      const auto& p = body.position_m;
      row.push_back(Vec3d{p[0], p[1], p[2]} + rotate(Quatd{w, x, y, z}, Vec3d{centre[0], centre[1], centre[2]}));
    }
    path.push_back(std::move(row));
    REQUIRE_FALSE(session.step(static_cast<std::uint64_t>(rate_Hz / 100)));
  }
  return path;
}

// The largest distance between two paths, as a share of the farthest that any body goes.
double difference(const Path& a, const Path& b) {
  REQUIRE(a.size() == b.size());
  double most = 0, span = 0;
  for (std::size_t row = 0; row < a.size(); ++row) {
    REQUIRE(a[row].size() == b[row].size());
    for (std::size_t body = 0; body < a[row].size(); ++body) {
      most = std::max(most, norm(a[row][body] - b[row][body]));
      span = std::max(span, norm(b[row][body] - b[0][body]));
    }
  }
  REQUIRE(span > 0.05);
  return most / span;
}

}  // namespace

TEST_CASE("pendulums, also of several shapes, and a slider move as MuJoCo moves them, to 1 % over 2 s") {
  TACTUS_NEEDS_COMPILER();
  const std::string name = GENERATE("pendulum.xml", "slider.xml", "mallet.xml");
  CAPTURE(name);
  CHECK(difference(path_here(name, 2), path_in_mujoco(name, 2)) < 0.01);
}

// MuJoCo by RK4 at 0.1 ms is within 0.1 % of itself at 0.01 ms. The integrator here is of first order: the difference
// falls with the step, 6 % at 1/4 ms, as imported, 1.8 % at 1/8 ms, 0.7 % at 1/32 ms.
TEST_CASE("a four-bar linkage comes to MuJoCo's motion as the step falls, to 1 % over 2 s") {
  TACTUS_NEEDS_COMPILER();
  const Path mujoco = path_in_mujoco("four_bar.xml", 2);
  const double coarse = difference(path_here("four_bar.xml", 2), mujoco);
  const double finer = difference(path_here("four_bar.xml", 2, 2000), mujoco);
  CAPTURE(coarse, finer);
  CHECK(finer < 0.5 * coarse);
  CHECK(difference(path_here("four_bar.xml", 2, 8000), mujoco) < 0.01);
}

TEST_CASE("the account says how far a closed loop of joints is off, and nothing of an open chain") {
  TACTUS_NEEDS_COMPILER();
  const auto says = [](const char* name) {
    return std::ranges::count_if(imported(name).account.changed, [](const std::string& line) {
      return line.find("closed loop of joints") != std::string::npos;
    });
  };
  CHECK(says("four_bar.xml") == 1);
  CHECK(says("pendulum.xml") == 0);
  CHECK(says("cabinet.urdf") == 0);
}

TEST_CASE("a stack stands: each box sinks by the slop and its load over its contact's stiffness") {
  TACTUS_NEEDS_COMPILER();
  const Path path = path_here("stack.xml", 2);
  // Three boxes of 1 kg and 0.1 m. A contact carries what is above it, as a spring of m w^2, with the effective mass of
  // the pair: its own on the ground, half of it between two (rt/physics/contact/softness.h).
  const physics::StepSettings settings;
  const double w = 2 * 3.141592653589793 * settings.contact_hertz;
  const double loads[] = {3 * kGravity / (w * w), 2 * kGravity / (0.5 * w * w), kGravity / (0.5 * w * w)};
  double sunk = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    sunk += settings.slop + loads[i];
    CHECK(0.1 * static_cast<double>(i) + 0.05 - path.back()[i].z == Approx(sunk).epsilon(0.01));
  }
}

TEST_CASE("on an incline of 30 degrees a block slides at g (sin a - mu cos a), and a rough one stays") {
  TACTUS_NEEDS_COMPILER();
  const Path path = path_here("incline.xml", 0.5);
  const double expected = 0.5 * kGravity * (0.5 - 0.3 * std::sqrt(0.75)) * 0.25;
  CHECK(norm(path.back()[0] - path[0][0]) == Approx(expected).epsilon(0.01));
  CHECK(norm(path.back()[1] - path[0][1]) < 1e-3);
}

TEST_CASE("cylinders roll down an incline at g sin a / (1 + I / (m r^2)), alone and as parts") {
  TACTUS_NEEDS_COMPILER();
  const Path path = path_here("roll.xml", 0.5);
  const double sliding = 0.5 * kGravity * 0.5 * 0.25;
  CHECK(norm(path.back()[0] - path[0][0]) == Approx(sliding / 1.5).epsilon(0.01));
  // Two discs of 0.1 kg and 0.04 m, an axle of 0.6 kg and 0.01 m.
  const double inertia = 2 * 0.5 * 0.1 * 0.0016 + 0.5 * 0.6 * 0.0001;
  CHECK(norm(path.back()[1] - path[0][1]) == Approx(sliding / (1 + inertia / (0.8 * 0.0016))).epsilon(0.01));
}
