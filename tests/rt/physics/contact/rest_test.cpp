// What brings a heap to rest: contacts that do not lose their load when their points change, and sweeps enough.
#include <catch2/catch.hpp>
#include <numeric>
#include <set>

#include "rt/physics/contact/contact_table.h"
#include "rt/physics/contact/softness.h"
#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::PhysicsBench;

namespace {

constexpr double kHalf = 0.05;

// Columns of cubes, each turned by any angle and a little tilted, that fall on a floor and lean on each other.
void add_columns(PhysicsBench& bench, std::uint64_t seed) {
  test::Random random(seed);
  bench.add_ground(1000, 0.5);
  for (BodyId id = 0; id < 54; ++id) {
    const Vec3d at{0.12 * (id % 3), 0.12 * (id / 3 % 3), kHalf + 0.13 * (id / 9)};
    const auto turn = quat_from_rotation_vector(Vec3d{0, 0, random(-3, 3)});
    bench.add_box(id, {kHalf, kHalf, kHalf}, 1, 0.5,
                  {at + random.vector(0.01), quat_from_rotation_vector(random.vector(0.1)) * turn});
  }
}

double fastest(const PhysicsBench& bench) {
  double speed = 0;
  for (const Body& body : bench.world.bodies()) speed = std::max(speed, norm(body.motion.velocity.linear));
  return speed;
}

double sum_of_impulses(const Contact& contact) {
  return std::accumulate(contact.points.begin(), contact.points.begin() + contact.count, 0.0,
                         [](double sum, const ContactPoint& p) { return sum + p.normal_impulse; });
}

}  // namespace

// Minutes under a sanitizer, of steps that the other worlds take too.
TEST_CASE("Columns of cubes come to rest, in steps of 1 ms and in steps of 10 ms", "[no-asan]") {
  for (const double dt : {1e-3, 1e-2})
    for (const std::uint64_t seed : {1u, 2u, 3u}) {
      PhysicsBench bench;
      bench.settings.dt = dt;
      bench.settings.sub_steps = dt > 5e-3 ? 10 : 4;
      bench.settings.contact_hertz = std::min(250.0, 0.2 * bench.settings.sub_steps / dt);
      add_columns(bench, seed);
      bench.run_seconds(10);
      INFO("step " << dt << " s, seed " << seed);
      CHECK(fastest(bench) < 1e-6);
    }
}

TEST_CASE("When a contact's points are chosen again, the nearest takes the impulse of one that is dropped") {
  const Capacities capacities{2, 0, 4, 4, 0};
  std::vector<Body> bodies;
  const Shape cube = Shape::box({kHalf, kHalf, kHalf});
  // A face turned by 45 degrees over another: eight corners, of which every other one is chosen.
  const Quatd turn = quat_from_rotation_vector(Vec3d{0, 0, 0.785398});
  bodies.push_back(make_dynamic_body(0, cube, 1, 0.5, {}));
  bodies.push_back(make_dynamic_body(1, cube, 1, 0.5, {{0, 0, 2 * kHalf - 1e-4}, turn}));
  ContactTable table(capacities);
  StepSettings settings;
  settings.recycle_tolerance_m = 0;
  const auto build = [&] {
    const BodyFrame frames[2] = {BodyFrame::of(bodies[0].motion.pose), BodyFrame::of(bodies[1].motion.pose)};
    const MotionBound reach[2];
    StepReport report;
    table.clear_pairs();
    table.add_pair(PairKey::of(0, 1, false), 0, 1);
    table.build({bodies, {}, frames, {}, reach}, settings, 1e-3, 1.0, report);
    REQUIRE(table.contacts().size() == 1);
    REQUIRE(table.contacts()[0].count == 4);
    std::set<std::uint32_t> features;
    for (const auto& point : table.contacts()[0].points) features.insert(point.feature);
    return features;
  };
  const std::set<std::uint32_t> first = build();
  for (auto& point : table.contacts()[0].points) point.normal_impulse = 1;
  REQUIRE(build() == first);
  CHECK(sum_of_impulses(table.contacts()[0]) == 4.0);
  // Tilted to every side: some corner that was not chosen is the deepest by far.
  int changed = 0;
  for (int side = 0; side < 8; ++side) {
    const double angle = 0.785398 * side;
    bodies[1].motion.pose.rotation =
        normalized(quat_from_rotation_vector(5e-3 * Vec3d{std::cos(angle), std::sin(angle), 0}) * turn);
    for (auto& point : table.contacts()[0].points) point.normal_impulse = 1;
    changed += build() != first;
    CHECK(sum_of_impulses(table.contacts()[0]) == Approx(4.0));
  }
  CHECK(changed > 0);
}

TEST_CASE("A sway needs two relax sweeps where contacts are as stiff as the sub-step allows") {
  CHECK(least_relax_sweeps(200.0, 1e-3) == 1);
  CHECK(least_relax_sweeps(250.0, 1e-3) == 2);
  CHECK(least_relax_sweeps(250.0, 0.25e-3) == 1);
}
