// What a sub-world takes over and reports at a synchronisation, what its border does, and what it does when the world
// is late.
#include "rt/haptics/coupling/sub_world.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "rt/base/status.h"
#include "tests/rt/haptics/coupling/sub_world_bench.h"
#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::haptics;
using namespace tactus::test::sub_world_bench;
using physics::BorderMode;
using test::kGravity;

TEST_CASE("a synchronisation reports what was, leavers included, and only then takes over what is new") {
  Bench bench(make_config());
  bench.next_with({ball(0, {0, 0, 0}, {{0.1, 0, 0}, {1, 2, 3}}), ball(1, {1, 0, 0}, {{0, 0.2, 0}, {0, 1, 0}}),
                   ball(2, {2, 0, 0}, {{0, 0, 0.3}, {}})});
  bench.synchronise();
  CHECK(bench.report->cycle == 0);
  CHECK(bench.report->ticks == 0);
  CHECK(bench.report->members.empty());
  bench.step(3);
  const BodyMotion before[] = {bench.motion(0), bench.motion(1), bench.motion(2)};

  const auto joiner = ball(5, {3, 1.0 / 3, 0}, {{0, 0, 0.7}, {0.1, 0, 0}});
  bench.next({0, 2, 5});
  REQUIRE(bench.snapshot->joiners.try_push(joiner));
  bench.synchronise();

  CHECK(bench.report->cycle == 1);
  CHECK(bench.report->ticks == 3);
  REQUIRE(bench.report->members.size() == 3);
  for (BodyId id = 0; id < 3; ++id) {
    CHECK(bench.report->members[id].id == id);
    CHECK(same_bits(bench.report->members[id].motion, before[id]));
  }
  CHECK(bench.sub_world.members() == 3);
  CHECK_FALSE(bench.is_member(1));
  CHECK(same_bits(bench.motion(0), before[0]));
  CHECK(same_bits(bench.motion(2), before[2]));
  CHECK(same_bits(bench.motion(5), joiner.motion));
  CHECK(bench.sub_world.ticks_in_cycle() == 0);
}

TEST_CASE("a member that stays is never overwritten, whatever the snapshot contains") {
  Bench bench(make_config());
  bench.next_with({ball(0, {}, {{0.1, 0, 0}, {}}), ball(1, {1, 0, 0}, {{0, 0.2, 0}, {}})});
  bench.synchronise();
  bench.step(3);
  const auto proxy = bench.motion(0), other = bench.motion(1);
  bench.next_with({ball(0, {9, 9, 9}), ball(1, {8, 8, 8})});
  bench.synchronise();
  CHECK(same_bits(bench.motion(0), proxy));
  CHECK(same_bits(bench.motion(1), other));
  CHECK(same_bits(bench.sub_world.proxy(), proxy));
}

TEST_CASE("the contacts of those that leave are reported as forces, the others' are not") {
  SubWorldConfig config = make_config();
  config.step.gravity = {0, 0, -kGravity};
  Bench bench(config, {ground()});
  bench.next_with({ball(0, {5, 0, 5}), cube(1, 0.05), cube(2, 0.15)});
  bench.snapshot->joiners[0].gravity_scale = 0;
  bench.synchronise();
  // Three sub-steps and not the configured four: the forces must be those of the sub-steps that were taken.
  bench.step(400, {}, 3);

  const auto sum_of = [](const physics::WarmStart& w) {
    double sum = 0;
    for (std::uint32_t i = 0; i < w.count; ++i) sum += w.normal_force[i];
    return sum;
  };
  SECTION("the upper cube leaves") {
    bench.next({0, 1});
    bench.synchronise();
    REQUIRE(bench.report->warm_starts.size() == 1);
    const auto& w = bench.report->warm_starts[0];
    CHECK(w.key == PairKey::of(1, 2, false));
    CHECK(sum_of(w) == Approx(kMass * kGravity).epsilon(0.01));
    CHECK(bench.sub_world.world().contacts().size() == 1);
  }
  SECTION("both leave") {
    bench.next({0});
    bench.synchronise();
    REQUIRE(bench.report->warm_starts.size() == 2);
    CHECK(bench.report->warm_starts[1].key == PairKey::of(1, kGround, true));
    CHECK(sum_of(bench.report->warm_starts[1]) == Approx(2 * kMass * kGravity).epsilon(0.01));
  }
  SECTION("nobody leaves") {
    bench.next({0, 1, 2});
    bench.synchronise();
    CHECK(bench.report->warm_starts.empty());
  }
}

TEST_CASE("a body that leaves and joins again with its warm start goes on as if it had stayed") {
  SubWorldConfig config = make_config();
  config.step.recycle_tolerance_m = 0;  // its contact is found again, so must be that of the one that stays
  config.step.gravity = {0, 0, -kGravity};
  const auto settle = [&](Bench& bench) {
    bench.next_with({ball(0, {5, 0, 5}), cube(1, 0.05), cube(2, 0.15)});
    bench.snapshot->joiners[0].gravity_scale = 0;
    bench.synchronise();
    bench.step(400);
  };
  Bench stays(config, {ground()}), returns(config, {ground()});
  settle(stays);
  settle(returns);
  auto away = cube(2, 0);
  away.motion = returns.motion(2);
  returns.next({0, 1});
  returns.synchronise();
  const auto carried = returns.report->warm_starts;
  returns.next({0, 1, 2});
  REQUIRE(returns.snapshot->joiners.try_push(away));
  SECTION("with it") {
    for (const auto& w : carried) REQUIRE(returns.snapshot->warm_starts.try_push(w));
    returns.synchronise();
    stays.step(20);
    returns.step(20);
    check_close(stays.motion(2).pose.position, returns.motion(2).pose.position, 1e-12);
    check_close(stays.motion(2).velocity.linear, returns.motion(2).velocity.linear, 1e-12);
  }
  SECTION("without it it does not: the comparison can tell") {
    returns.synchronise();
    stays.step(20);
    returns.step(20);
    CHECK(norm(stays.motion(2).pose.position - returns.motion(2).pose.position) > 1e-9);
  }
}

TEST_CASE("the mean device wrench of a cycle is the momentum that the proxy got in it, over its time") {
  Bench bench(make_config());
  bench.next_with({ball(kProxy, {})});
  bench.synchronise();
  const DeviceTarget target = target_at({0.002, -0.001, 0.003}, quat_from_rotation_vector(Vec3d{0.01, 0.02, -0.01}));
  const double inertia = bench.sub_world.world().bodies()[0].inertia.x;
  Twistd before;
  for (const std::uint32_t ticks : {5u, 8u}) {
    Wrenchd felt;
    for (std::uint32_t i = 0; i < ticks; ++i) {
      bench.step(1, target);
      felt += bench.last.on_device;
    }
    const Twistd after = bench.motion(kProxy).velocity;
    bench.next({kProxy});
    bench.synchronise();
    const double time_s = ticks * kTick_s;
    const Wrenchd& mean = bench.report->mean_device_wrench;
    CHECK(bench.report->ticks == ticks);
    check_close(mean.force, (kMass / time_s) * (after.linear - before.linear), 1e-10);
    check_close(mean.torque, (inertia / time_s) * (after.angular - before.angular), 1e-10);
    check_close(mean.force, (-1.0 / ticks) * felt.force, 1e-10);
    check_close(mean.torque, (-1.0 / ticks) * felt.torque, 1e-10);
    CHECK(norm(mean.force) > 0.1);
    before = after;
  }
}

TEST_CASE("a proxy that is not held comes to rest where it is, and the device feels nothing") {
  Bench bench(make_config());
  bench.next_with({ball(kProxy, {}, {{0.2, 0, 0}, {}})});
  bench.synchronise();
  for (int i = 0; i < 1000; ++i) {
    bench.step(1, {false, {{5, 5, 5}, {}}, {{1, 1, 1}, {}}});
    REQUIRE(bench.last.on_device == Wrenchd{});
  }
  // m v' = -B v: it stops after m v / B, here 2 cm, whatever the step.
  CHECK(norm(bench.motion(kProxy).velocity.linear) < 1e-4);
  CHECK(bench.motion(kProxy).pose.position.x == Approx(kMass * 0.2 / 5).epsilon(0.01));
}

TEST_CASE("a border contact carries a member's weight and reports the momentum that it gave, at its point") {
  SubWorldConfig config = make_config();
  config.step.gravity = {0, 0, -kGravity};
  Bench bench(config);
  bench.next_with({ball(1, {0.3, 0.2, kRadius}, {{0.05, 0, 0}, {}})});
  REQUIRE(bench.snapshot->border.try_push(support(1, 100, 0.5)));
  bench.synchronise();
  CHECK(bench.report->border.empty());
  REQUIRE(bench.sub_world.border_contacts() == 1);
  const Vec3d before = bench.motion(1).velocity.linear;
  bench.step(5);
  const auto after = bench.motion(1);
  bench.next({1});
  bench.synchronise();
  REQUIRE(bench.report->border.size() == 1);
  const BorderReturn& given = bench.report->border[0];
  CHECK(given.member == 1);
  CHECK(given.outside == kOutside);
  CHECK(given.feature == 7);
  check_close(given.point, after.pose * Vec3d{0, 0, -kRadius}, 1e-15);
  CHECK(given.normal_impulse_Ns == Approx(kMass * kGravity * 5 * kTick_s).epsilon(1e-3));
  const Vec3d gained = kMass * (after.velocity.linear - before);
  check_close(gained, Vec3d{0, 0, given.normal_impulse_Ns - kMass * kGravity * 5 * kTick_s} + given.tangent_impulse,
              1e-12);
  CHECK(given.tangent_impulse.x < 0);
}

TEST_CASE("a synchronisation renews the border: line at the member's point, friction holds again, sums from zero") {
  SubWorldConfig config = make_config();
  config.step.gravity = {0, 0, -kGravity};
  Bench bench(config);
  bench.next_with({ball(1, {0, 0, kRadius}, {{0.5, 0, 0}, {}}), ball(2, {1, 0, kRadius})});
  REQUIRE(bench.snapshot->border.try_push(support(1, 100, 0.01)));  // too slippery to hold
  REQUIRE(bench.snapshot->border.try_push(support(2, 100, 0.5)));
  bench.synchronise();
  bench.step(5);
  REQUIRE(bench.border(0).friction_free);
  const auto old_slipping = bench.border(0), old_resting = bench.border(1);
  REQUIRE(old_resting.normal_impulse > 0);

  bench.next({1, 2});
  REQUIRE(bench.snapshot->border.try_push(support(2, 80, 0.4)));  // in another order, and one of them a new feature
  REQUIRE(bench.snapshot->border.try_push(support(1, 80, 0.4)));
  REQUIRE(bench.snapshot->border.try_push(support(1, 80, 0.4, 8)));
  REQUIRE(bench.snapshot->border.try_push(support(33, 80)));  // its member is not here
  bench.synchronise();
  REQUIRE(bench.sub_world.border_contacts() == 3);
  for (std::uint32_t i = 0; i < 3; ++i) {
    const auto& now = bench.border(i);
    CHECK(now.impulse_rate == 80);
    CHECK(now.friction == 0.4);
    CHECK_FALSE(now.friction_free);
    CHECK(now.line_point == bench.motion(now.member).pose * now.member_anchor);
    CHECK(now.total_normal_impulse == 0);
    CHECK(now.total_tangent_impulse == Vec3d{});
    CHECK(now.work == 0);
  }
  CHECK(bench.border(0).normal_impulse == old_resting.normal_impulse);
  CHECK(bench.border(0).tangent_impulse[0] == old_resting.tangent_impulse[0]);
  CHECK(bench.border(1).normal_impulse == old_slipping.normal_impulse);
  CHECK(bench.border(2).normal_impulse == 0);
}

TEST_CASE("the work of the border is summed over all cycles: on a free body it is the kinetic energy gained") {
  SubWorldConfig config = make_config();
  config.border_mode = BorderMode::kReplay;
  Bench bench(config);
  constexpr double kForce = 3;
  bench.next_with({ball(1, {})});
  for (std::uint32_t cycle = 0; cycle < 3; ++cycle) {
    REQUIRE(bench.snapshot->border.try_push(support(1, kForce)));
    bench.synchronise();
    if (cycle > 0) CHECK(bench.report->border[0].normal_impulse_Ns == Approx(kForce * 5 * kTick_s).epsilon(1e-12));
    bench.step(5);
    bench.next({1});
    const double speed = kForce * (cycle + 1) * 5 * kTick_s / kMass;
    CHECK(bench.motion(1).velocity.linear.z == Approx(speed).epsilon(1e-12));
    CHECK(bench.sub_world.border_work_J() == Approx(0.5 * kMass * speed * speed).epsilon(1e-12));
  }
}

TEST_CASE("border contacts beyond the capacity are dropped, counted and reported once") {
  SubWorldConfig config = make_config();
  config.capacities.border_contacts = 2;
  Bench bench(config);
  bench.next_with({ball(1, {})});
  for (std::uint32_t feature = 0; feature < 5; ++feature)
    REQUIRE(bench.snapshot->border.try_push(support(1, 1, 0, feature)));
  bench.synchronise();
  CHECK(bench.sub_world.border_contacts() == 2);
  bench.step();
  CHECK(bench.last.report.capacity_bits == physics::kBorderContactsFull);
  CHECK(bench.last.report.dropped == 3);
  CHECK((bench.last.status & kCapacityExceeded) != 0);
  bench.step();
  CHECK(bench.last.report.capacity_bits == 0);
}

TEST_CASE("the proxy touches what pushes it: a member, or an outside body") {
  Bench bench(make_config());
  bench.next_with({ball(kProxy, {})});
  SECTION("nothing") {
    bench.synchronise();
    bench.step();
    CHECK((bench.last.status & kProxyContact) == 0);
  }
  SECTION("a member") {
    bench.next_with({ball(kProxy, {}), ball(1, {2 * kRadius - 1e-4, 0, 0})});
    bench.synchronise();
    bench.step(1, target_at({0.01, 0, 0}));
    CHECK((bench.last.status & kProxyContact) != 0);
  }
  SECTION("an outside body") {
    bench.next_with({ball(kProxy, {0, 0, kRadius})});
    REQUIRE(bench.snapshot->border.try_push(support(kProxy, 100)));
    bench.synchronise();
    bench.step(1, target_at({0, 0, kRadius - 0.01}));
    CHECK((bench.last.status & kProxyContact) != 0);
  }
}

TEST_CASE("a late world fades by the rule, and all of it ends with the next snapshot") {
  SubWorldConfig config = make_config();
  config.step.gravity = {0, 0, -kGravity};
  Bench bench(config);
  const Vec3d velocity{0.02, -0.01, 0.03};
  bench.next_with({ball(1, {0, 0, kRadius})});
  BorderPoint point = support(1, 0);  // capped at nothing: only a frozen border holds the ball
  point.outside_velocity = velocity;
  REQUIRE(bench.snapshot->border.try_push(point));
  bench.synchronise();
  const std::uint32_t r = config.ratio;
  for (std::uint32_t k = 0; k < 150; ++k) {
    bench.step();
    const std::uint32_t late = k >= r ? k - r + 1 : 0;  // ticks beyond the cycle's end, this one included
    const double fade = late < r ? 1.0 - static_cast<double>(late) / r : 0.0;
    CAPTURE(k, late);
    check_close(bench.border(0).outside_velocity, fade * velocity, 1e-15);
    CHECK(((bench.last.status & kWorldLate) != 0) == (late > 0));
    CHECK(((bench.last.status & kBorderFrozen) != 0) == (late > 4 * r));
    CHECK(((bench.last.status & kWorldFade) != 0) == (late * kTick_s > 0.1 + 1e-9));
    const double scale = late <= 100 ? 1.0 : late >= 110 ? 0.0 : 1.0 - 0.1 * (late - 100);
    CHECK(bench.last.force_scale == Approx(scale).margin(1e-12));
    if (late == 4 * r) CHECK(bench.motion(1).velocity.linear.z < -0.1);  // it fell until then
    if (late == 4 * r + 1) CHECK(std::abs(bench.motion(1).velocity.linear.z) < 1e-9);
  }
  bench.next({1});
  REQUIRE(bench.snapshot->border.try_push(point));
  bench.synchronise();
  CHECK(bench.report->ticks == 150);
  bench.step();
  CHECK((bench.last.status & (kWorldLate | kBorderFrozen | kWorldFade)) == 0);
  CHECK(bench.last.force_scale == 1);
  CHECK(bench.border(0).outside_velocity == velocity);
  CHECK(bench.motion(1).velocity.linear.z < -0.5 * kGravity * kTick_s);  // and it falls again
}
