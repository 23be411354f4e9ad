#include "rt/haptics/coupling/plane_coupling.h"

#include "rt/base/status.h"
#include "tests/rt/haptics/coupling/sub_world_bench.h"

#include <catch2/catch.hpp>
#include <random>

using namespace tactus;
using namespace tactus::haptics;
using namespace tactus::test::sub_world_bench;

TEST_CASE("above a plane the proxy is at the device, below as near to it as the plane allows") {
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

TEST_CASE("friction holds a point at 0.99 of its coefficient, and lets it slide at 1.01 to the edge of the cone") {
  const double mu = GENERATE(0.1, 0.6, 1.5);
  const auto keep = GENERATE(keep_above, keep_on);
  const Vec3d hold{0.3, -0.2, 7};  // what is along the normal does not matter
  const ProxyPlane ground{
      .normal = {0, 0, 1}, .offset = 0.1, .friction = mu, .hold = hold, .surface_velocity = {0.01, 0, 0}};
  const double deep = 2e-3;
  const Vec3d way{0.6, 0.8, 0};
  const auto pulled = [&](double share) {
    return keep({&ground, 1}, Vec3d{0.3, -0.2, 0.1 - deep} + (share * mu * deep) * way, {0.1, 0.2, -0.3});
  };
  const HeldProxy held = pulled(0.99);
  CHECK_FALSE(held.slides);
  check_close(held.position, {0.3, -0.2, 0.1}, 1e-15);
  check_close(held.velocity, ground.surface_velocity, 1e-15);
  for (const double share : {1.01, 3.0}) {
    const HeldProxy slid = pulled(share);
    CHECK(slid.slides);
    check_close(slid.position, Vec3d{0.3, -0.2, 0.1} + ((share - 1) * mu * deep) * way, 1e-15);
    check_close(slid.velocity, {0.1, 0.2, 0}, 1e-15);
  }
}

TEST_CASE("among planes with friction the pull is one that their cones bear together") {
  std::mt19937_64 random(GENERATE(range(1u, 41u)));
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto vector = [&] { return Vec3d{uniform(random), uniform(random), uniform(random)}; };
  ProxyPlanes planes;
  double bound = 0;
  for (int i = 0; i < 6; ++i) {
    Vec3d normal = vector() * 0.6;
    normal.z = 1;
    const double mu = 0.5 * (1 + uniform(random));
    REQUIRE(planes.try_push({.normal = normal * (1 / norm(normal)),
                             .offset = 0.1 * uniform(random),
                             .friction = mu,
                             .hold = vector(),
                             .surface_velocity = {}}));
    bound = std::max(bound, mu);
  }
  const Vec3d wanted = vector() * 0.2 - Vec3d{0, 0, 0.2};
  const HeldProxy held = keep_above(planes.span(), wanted, {});
  for (const ProxyPlane& plane : planes) CHECK(dot(plane.normal, held.position) >= plane.offset - 5e-2);
  // Every normal is within atan(0.6 sqrt 2) of z, every cone within atan(bound) of its normal.
  const Vec3d pull = held.position - wanted;
  if (norm(pull) > 0) CHECK(pull.z >= std::cos(std::atan(0.85) + std::atan(bound)) * norm(pull) - 1e-12);
}

namespace {

// The next snapshot has these points of the proxy.
void adopt(Bench& bench, std::vector<BorderPoint> points, bool joins = false) {
  if (joins)
    bench.next_with({ball(kProxy, {0, 0, kRadius + 1e-3})});
  else
    bench.next({kProxy});
  for (const BorderPoint& point : points) REQUIRE(bench.snapshot->border.try_push(point));
  bench.synchronise();
}

// The same, with planes that were there in the cycle before: nothing has to be blended in.
void adopt_old(Bench& bench, std::vector<BorderPoint> points) {
  adopt(bench, points, true);
  adopt(bench, points);
}

}  // namespace

TEST_CASE("planes: the spring between device and proxy is felt, and the proxy alone is reported") {
  const auto scheme = GENERATE(CouplingScheme::kPlane, CouplingScheme::kPlanes, CouplingScheme::kLinearised);
  const SubWorldConfig config = make_config(scheme);
  Bench bench(config);
  adopt_old(bench, {support(kProxy, 1)});  // the surface is z = 0
  const double deep = 2e-3;
  bench.step(1, target_at({0.01, 0, kRadius - deep}));
  CHECK((bench.last.status & kProxyContact) != 0);
  check_close(bench.last.on_device.force, {0, 0, config.gains.stiffness_N_per_m * deep}, 1e-9);
  check_close(bench.motion(kProxy).pose.position, {0.01, 0, kRadius}, 1e-12);
  CHECK(same_bits(bench.motion(kProxy), bench.sub_world.proxy()));

  bench.step(1, target_at({0.01, 0, kRadius + deep}));  // the hand withdraws
  const double pull = scheme == CouplingScheme::kLinearised ? config.gains.stiffness_N_per_m * deep : 0;
  check_close(bench.last.on_device.force, {0, 0, -pull}, 1e-9);

  bench.next({kProxy});
  bench.synchronise();
  REQUIRE(bench.report->members.size() == 1);
  CHECK(bench.report->members[0].id == kProxy);
  check_close(bench.report->mean_device_wrench.force, {0, 0, 0.5 * (pull - config.gains.stiffness_N_per_m * deep)},
              1e-9);
  bench.step(config.ratio, target_at({0.01, 0, kRadius - deep}));  // no contact any more
  CHECK(bench.last.on_device == Wrenchd{});
}

TEST_CASE("planes: a proxy turns with the device, and its contact point with it") {
  SubWorldConfig config = make_config(CouplingScheme::kPlanes);
  Bench bench(config);
  adopt_old(bench, {support(kProxy, 1)});
  // Upside down the point that was the lowest is the highest: nothing holds before the ball is two radii lower.
  const Quatd over = quat_from_rotation_vector(Vec3d{3.14159265358979, 0, 0});
  bench.step(1, target_at({0, 0, -0.9 * kRadius}, over));
  CHECK(bench.last.on_device == Wrenchd{});
  bench.step(1, target_at({0, 0, -1.1 * kRadius}, over));
  CHECK(bench.last.on_device.force.z == Approx(config.gains.stiffness_N_per_m * 0.1 * kRadius));
  CHECK(norm(bench.last.on_device.torque) == 0);
}

TEST_CASE("planes: a dragged proxy is held up to its coefficient of friction, and then slides with that much force") {
  const auto scheme = GENERATE(CouplingScheme::kPlane, CouplingScheme::kPlanes, CouplingScheme::kLinearised);
  const SubWorldConfig config = make_config(scheme);
  const double mu = 0.4, deep = 2e-3;
  Bench bench(config);
  adopt_old(bench, {support(kProxy, 1, mu)});
  bench.step(1, target_at({0, 0, kRadius - deep}));
  bench.step(1, target_at({0.99 * mu * deep, 0, kRadius - deep}));
  CHECK(bench.last.on_device.force.x == Approx(-0.99 * mu * config.gains.stiffness_N_per_m * deep));
  CHECK(std::abs(bench.motion(kProxy).pose.position.x) < 1e-12);
  bench.step(1, target_at({1.01 * mu * deep, 0, kRadius - deep}));
  CHECK(bench.motion(kProxy).pose.position.x == Approx(0.01 * mu * deep));
  // In motion the damper presses and drags too: the whole force is in the cone, and at its edge while it slides.
  for (int k = 1; k < 40; ++k) {
    if (k % 4 == 0) adopt(bench, {support(kProxy, 1, mu)});
    const DeviceTarget moving{true, {{1.01 * mu * deep + 1e-3 * k, 0, kRadius - deep}, {}}, {{0.05, 0, -0.02}, {}}};
    bench.step(1, moving);
    const Vec3d& force = bench.last.on_device.force;
    REQUIRE(force.z == Approx(config.gains.stiffness_N_per_m * deep + config.gains.damping_Ns_per_m * 0.02));
    REQUIRE(force.x == Approx(-mu * force.z));
  }
  // Let go and taken again elsewhere, nothing of the past holds.
  bench.step(1);
  bench.step(1, target_at({1, 0, kRadius - deep}));
  check_close(bench.last.on_device.force, {0, 0, config.gains.stiffness_N_per_m * deep}, 1e-9);
}

TEST_CASE("planes: what friction holds goes along with the surface, and stands still with a late world's") {
  const SubWorldConfig config = make_config(CouplingScheme::kPlanes);
  Bench bench(config);
  BorderPoint belt = support(kProxy, 1, 0.8);
  belt.outside_velocity = {0.1, 0, 0};
  adopt_old(bench, {belt});
  const double deep = 5e-3;
  bench.step(config.ratio, target_at({0, 0, kRadius - deep}));
  const double carried_N = config.gains.stiffness_N_per_m * 0.1 * config.ratio * kTick_s;
  CHECK(bench.last.on_device.force.x == Approx(carried_N));
  bench.step(2, target_at({0, 0, kRadius - deep}));
  CHECK(bench.last.on_device.force.x == Approx(carried_N));
}

TEST_CASE(
    "planes: new planes come in over a cycle, no tick changes the force by more than its share of the difference") {
  const auto scheme = GENERATE(CouplingScheme::kPlane, CouplingScheme::kPlanes, CouplingScheme::kLinearised);
  const SubWorldConfig config = make_config(scheme);
  std::mt19937_64 random(GENERATE(range(1u, 21u)));
  std::uniform_real_distribution<double> uniform(-1, 1);
  const DeviceTarget still = target_at({0.01, 0, kRadius});
  const auto plane = [&] {
    BorderPoint point = support(kProxy, 1, 0.3 * (1 + uniform(random)));
    const Vec3d normal = Vec3d{0.5 * uniform(random), 0.5 * uniform(random), 1};
    point.normal = normal * (1 / norm(normal));
    point.separation_m = 5e-3 * uniform(random);  // the surface is higher or lower: also out of reach
    return point;
  };
  Bench bench(config);
  adopt(bench, {plane()}, true);
  bench.step(config.ratio, still);
  for (int cycle = 0; cycle < 10; ++cycle) {
    const Vec3d before = bench.last.on_device.force;
    adopt(bench, uniform(random) < -0.6 ? std::vector<BorderPoint>{} : std::vector<BorderPoint>{plane()});
    std::vector<Vec3d> force{before};
    for (std::uint32_t i = 0; i < config.ratio; ++i) {
      bench.step(1, still);
      force.push_back(bench.last.on_device.force);
    }
    const double share = norm(force.back() - before) / config.ratio;
    for (std::size_t i = 1; i < force.size(); ++i) REQUIRE(norm(force[i] - force[i - 1]) <= share + 1e-9);
  }
}

TEST_CASE("planes: what is saved within a cycle goes on with the same bits") {
  const SubWorldConfig config = make_config(GENERATE(CouplingScheme::kPlanes, CouplingScheme::kLinearised));
  Bench bench(config), again(config);
  adopt_old(bench, {support(kProxy, 1, 0.5)});
  adopt(bench, {support(kProxy, 1, 0.5), support(kProxy, 1, 0.2, 8)});
  bench.step(2, target_at({1e-4, 0, 0.9 * kRadius}));
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
