#include "sim/exchange/proxy_planes.h"

#include <catch2/catch.hpp>

#include "rt/physics/collision/pair_finder.h"

using namespace tactus;
using namespace tactus::physics;

namespace {

constexpr BodyId kProxy = 2;
constexpr double kStep_s = 8e-3;
using Planes = FixedVector<haptics::BorderPoint, haptics::kMaxBorderPoints>;

// A cube of 0.1 m and 1 kg that falls onto the ground, or onto another cube there.
struct Bench {
  World world{{.bodies = 4, .fixed_bodies = 2, .pairs = 32, .contacts = 32}};
  StepSettings settings;

  explicit Bench(bool on_cube, BodyId proxy) {
    settings.dt = kStep_s;
    settings.sub_steps = 8;
    settings.gravity = {0, 0, -9.81};
    REQUIRE(world.insert(make_fixed_body(50, Shape::plane(), 0.5, {})));
    const auto cube = Shape::box({0.05, 0.05, 0.05});
    if (on_cube) REQUIRE(world.insert(make_dynamic_body(1, cube, 1.0, 0.5, {{0, 0, 0.05}, {}})));
    REQUIRE(world.insert(make_dynamic_body(proxy, cube, 1.0, 0.5, {{0, 0, on_cube ? 0.15 : 0.05}, {}})));
    world.index_fixed_bodies();
    for (int i = 0; i < 100; ++i) {
      world.begin_step(settings);
      (void)find_pairs_brute_force(world.bounds(), world.dynamic_pairs());
      (void)world.finish_step(settings, {});
    }
  }
};

}  // namespace

TEST_CASE("A cube at rest has a plane at each foot, which together carry its weight, on the ground or on a cube") {
  const bool on_cube = GENERATE(false, true);
  const BodyId proxy = GENERATE(BodyId{0}, BodyId{2});  // first or second of its pair
  const Bench bench(on_cube, proxy);
  Planes planes;
  sim::fill_proxy_planes(bench.world, proxy, kStep_s, 16, planes);
  REQUIRE(planes.size() == 4);
  double force = 0;
  const double top = on_cube ? 0.1 : 0;
  const Posed& pose = bench.world.find(proxy)->motion.pose;
  for (const auto& plane : planes) {
    CHECK(plane.member == proxy);
    CHECK(plane.outside == (on_cube ? 1u : 50u));
    CHECK(norm(plane.normal - Vec3d{0, 0, 1}) < 1e-4);
    force += plane.impulse_rate_N;
    // The surface is where the proxy's point is that touches it.
    const double gap = plane.separation_m + dot(plane.normal, pose * plane.member_anchor - plane.outside_point);
    CHECK(std::abs(gap) < 2e-5);
    CHECK(std::abs((pose * plane.member_anchor).z - top) < 5e-5);
    CHECK(norm(plane.outside_velocity) < 1e-3);
  }
  CHECK(force == Approx(9.81).epsilon(1e-3));
}

TEST_CASE("Of more planes than asked for, those that press most stay, and what touches nothing has none") {
  const Bench bench(true, kProxy);
  Planes all, one;
  sim::fill_proxy_planes(bench.world, kProxy, kStep_s, 16, all);
  sim::fill_proxy_planes(bench.world, kProxy, kStep_s, 1, one);
  REQUIRE(one.size() == 1);
  for (const auto& plane : all) CHECK(one[0].impulse_rate_N >= plane.impulse_rate_N);
  sim::fill_proxy_planes(bench.world, 77, kStep_s, 16, all);
  CHECK(all.empty());
}

TEST_CASE("At the seam of two flush tiles the proxy has the planes of their faces, none of a side") {
  World world({.bodies = 4, .fixed_bodies = 2, .pairs = 32, .contacts = 32});
  StepSettings settings;
  settings.dt = kStep_s;
  settings.sub_steps = 8;
  settings.gravity = {0, 0, -9.81};
  for (BodyId i = 0; i < 2; ++i)
    REQUIRE(world.insert(make_fixed_body(50 + i, Shape::box({0.1, 0.1, 0.1}), 0, {{0.2 * i, 0, -0.1}, {}})));
  Body body = make_dynamic_body(kProxy, Shape::box({0.03, 0.03, 0.03}), 1.0, 0, {{0.02, 0, 0.03}, {}});
  body.motion.velocity.linear.x = 0.1;
  REQUIRE(world.insert(body));
  world.index_fixed_bodies();
  int at_seam = 0;
  for (int i = 0; i < 120; ++i) {
    world.begin_step(settings);
    (void)find_pairs_brute_force(world.bounds(), world.dynamic_pairs());
    (void)world.finish_step(settings, {});
    Planes planes;
    sim::fill_proxy_planes(world, kProxy, kStep_s, 16, planes);
    REQUIRE(planes.size() >= 4);
    for (const auto& plane : planes) REQUIRE(norm(plane.normal - Vec3d{0, 0, 1}) < 1e-3);
    for (const Contact& contact : world.contacts()) at_seam += contact.is_redundant() ? 1 : 0;
  }
  CHECK(at_seam > 0);
  CHECK(world.find(kProxy)->motion.pose.position.x == Approx(0.02 + 0.1 * 120 * kStep_s).epsilon(0.01));
}
