#include "rt/haptics/plane_coupling.h"

#include "rt/base/status.h"
#include "tests/rt/haptics/sub_world_bench.h"

#include <catch2/catch.hpp>
#include <random>

using namespace tactus;
using namespace tactus::haptics;
using namespace tactus::test::sub_world_bench;

TEST_CASE("above a plane the proxy is where the device wants it, below as near as the plane allows") {
  const ProxyPlane ground{{0, 0, 1}, 0.1};
  const HeldProxy free = keep_above({&ground, 1}, {1, 2, 0.3}, {0.1, 0, -0.2});
  CHECK_FALSE(free.touches);
  CHECK(free.position == Vec3d{1, 2, 0.3});
  CHECK(free.velocity == Vec3d{0.1, 0, -0.2});
  const HeldProxy held = keep_above({&ground, 1}, {1, 2, 0.05}, {0.1, 0, -0.2});
  CHECK(held.touches);
  check_close(held.position, {1, 2, 0.1}, 1e-15);
  check_close(held.velocity, {0.1, 0, 0}, 1e-15);
  check_close(keep_above({&ground, 1}, {1, 2, 0.05}, {0, 0, 0.2}).velocity, {0, 0, 0.2}, 1e-15);  // it leaves
}

TEST_CASE(
    "among planes it is the nearest point: no other point above all of them lies more towards where it is wanted") {
  std::mt19937_64 random(GENERATE(range(1u, 41u)));
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&] { return Vec3d{uniform(random), uniform(random), uniform(random)}; };
  // Steep enough to each other that the sweeps get there: normals in a cone about z.
  ProxyPlanes planes;
  for (int i = 0; i < 6; ++i) {
    Vec3d normal = vector() * 0.6;
    normal.z = 1;
    REQUIRE(planes.try_push({normal * (1 / norm(normal)), 0.1 * uniform(random)}));
  }
  const Vec3d wanted = vector() * 0.2 - Vec3d{0, 0, 0.2};
  const HeldProxy held = keep_above(planes.span(), wanted, {});
  for (const ProxyPlane& plane : planes) CHECK(dot(plane.normal, held.position) >= plane.offset - 1e-3);
  for (int i = 0; i < 200; ++i) {
    const Vec3d other = vector() + Vec3d{0, 0, 1};
    bool above = true;
    for (const ProxyPlane& plane : planes) above = above && dot(plane.normal, other) >= plane.offset;
    if (above) CHECK(dot(held.position - wanted, other - held.position) >= -1e-3);
  }
}

TEST_CASE("linearised the planes hold from both sides: the force of a contact is F0 + J (x - x0)") {
  const ProxyPlane planes[] = {{{0, 0, 1}, 0.1}, {{1, 0, 0}, 0}};
  const auto force = [&](const Vec3d& wanted) { return keep_on(planes, wanted, {}).position - wanted; };
  const Vec3d start{0.01, 5, 0.09}, step{0.02, 0.3, 0.05};
  // J: -1 along both normals, 0 along y.
  check_close(force(start), {-0.01, 0, 0.01}, 1e-15);
  check_close(force(start + step), force(start) + Vec3d{-step.x, 0, -step.z}, 1e-15);
  CHECK_FALSE(keep_on({}, start, {}).touches);
  CHECK(keep_on({}, start, step).velocity == step);
}

TEST_CASE("planes: the spring between device and proxy is felt, and the proxy alone is reported") {
  const auto scheme = GENERATE(CouplingScheme::kPlane, CouplingScheme::kPlanes, CouplingScheme::kLinearised);
  const SubWorldConfig config = make_config(scheme);
  Bench bench(config);
  bench.next_with({ball(kProxy, {0, 0, kRadius + 1e-3})});       // not there yet
  REQUIRE(bench.snapshot->border.try_push(support(kProxy, 1)));  // the surface is z = 0
  bench.synchronise();
  const double deep = 2e-3;
  bench.step(1, target_at({0.01, 0, kRadius - deep}));
  CHECK((bench.last.status & kProxyContact) != 0);
  check_close(bench.last.on_device.force, {0, 0, config.stiffness_N_per_m * deep}, 1e-9);
  check_close(bench.motion(kProxy).pose.position, {0.01, 0, kRadius}, 1e-12);
  CHECK(same_bits(bench.motion(kProxy), bench.sub_world.proxy()));

  bench.step(1, target_at({0.01, 0, kRadius + deep}));  // the hand withdraws
  const double pull = scheme == CouplingScheme::kLinearised ? config.stiffness_N_per_m * deep : 0;
  check_close(bench.last.on_device.force, {0, 0, -pull}, 1e-9);

  bench.next({kProxy});
  bench.synchronise();
  REQUIRE(bench.report->members.size() == 1);
  CHECK(bench.report->members[0].id == kProxy);
  check_close(bench.report->mean_device_wrench.force, {0, 0, 0.5 * (pull - config.stiffness_N_per_m * deep)}, 1e-9);
  bench.step(1, target_at({0.01, 0, kRadius - deep}));  // no contact any more
  CHECK(bench.last.on_device == Wrenchd{});
}

TEST_CASE("planes: a proxy turns with the device, and its contact point with it") {
  SubWorldConfig config = make_config(CouplingScheme::kPlanes);
  Bench bench(config);
  bench.next_with({ball(kProxy, {0, 0, kRadius})});
  REQUIRE(bench.snapshot->border.try_push(support(kProxy, 1)));
  bench.synchronise();
  // Upside down the point that was the lowest is the highest: nothing holds before the ball is two radii lower.
  const Quatd over = quat_from_rotation_vector(Vec3d{3.14159265358979, 0, 0});
  bench.step(1, target_at({0, 0, -0.9 * kRadius}, over));
  CHECK(bench.last.on_device == Wrenchd{});
  bench.step(1, target_at({0, 0, -1.1 * kRadius}, over));
  CHECK(bench.last.on_device.force.z == Approx(config.stiffness_N_per_m * 0.1 * kRadius));
  CHECK(norm(bench.last.on_device.torque) == 0);
}

TEST_CASE("planes: what is saved within a cycle goes on with the same bits") {
  const SubWorldConfig config = make_config(GENERATE(CouplingScheme::kPlanes, CouplingScheme::kLinearised));
  Bench bench(config), again(config);
  bench.next_with({ball(kProxy, {0, 0, kRadius})});
  REQUIRE(bench.snapshot->border.try_push(support(kProxy, 1)));
  bench.synchronise();
  bench.step(2, target_at({0, 0, 0.9 * kRadius}));
  std::vector<std::byte> bytes(bench.sub_world.save_size_bound());
  ByteWriter out(bytes);
  bench.sub_world.save(out);
  ByteReader in(std::span<const std::byte>(bytes).first(out.size()));
  REQUIRE(again.sub_world.restore(in));
  for (const double height : {0.8, 0.95, 1.1}) {
    bench.step(1, target_at({0, 0, height * kRadius}));
    again.step(1, target_at({0, 0, height * kRadius}));
    CHECK(bench.last.on_device == again.last.on_device);
  }
  CHECK(bench.sub_world.state_hash() == again.sub_world.state_hash());
}
