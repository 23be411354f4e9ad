// The ghost border of a sub-world: what crosses the border in a cycle, and how it is accounted for.
#include "rt/base/status.h"
#include "tests/rt/haptics/sub_world_bench.h"

using namespace tactus;
using namespace tactus::test::sub_world_bench;
using haptics::OutsideBody;

namespace {

SubWorldConfig ghost_config() {
  SubWorldConfig config = make_config();
  config.border_mode = physics::BorderMode::kGhost;
  return config;
}

OutsideBody outside(double inverse_mass, const Vec3d& velocity = {}) {
  OutsideBody body;
  body.id = kOutside;
  body.centre = {0, 0, -kRadius};
  body.velocity.linear = velocity;
  body.admittance.linear = SymMat3<double>::identity(inverse_mass);
  return body;
}

BorderPoint touch(double force_N, double inverse_mass, double friction = 0) {
  BorderPoint point = support(1, force_N, friction);
  point.member_anchor = {0, 0, -kRadius}, point.outside_point = {0, 0, -kRadius};
  point.outside_inverse_mass = inverse_mass;
  return point;
}

const physics::BorderGhost<double>& ghost_of(const Bench& bench) { return bench.sub_world.world().border_ghosts()[0]; }

}  // namespace

TEST_CASE("What a cycle reports of a ghost is the momentum that its member lost, normal and tangential") {
  Bench bench(ghost_config());
  const double mass = 3;
  bench.next_with({ball(1, {}, {{0.1, 0, -0.2}, {}})});
  REQUIRE(bench.snapshot->outside.try_push(outside(1 / mass)));
  REQUIRE(bench.snapshot->border.try_push(touch(0, 1 / mass, 0.3)));
  bench.synchronise();
  bench.step(5);
  const Vec3d lost = kMass * (Vec3d{0.1, 0, -0.2} - bench.motion(1).velocity.linear);
  check_close(mass * ghost_of(bench).velocity.linear, lost, 1e-15);
  bench.next({1});
  bench.synchronise();
  REQUIRE(bench.report->border.size() == 1);
  const auto& given = bench.report->border[0];
  check_close(-given.normal_impulse_Ns * given.normal - given.tangent_impulse, lost, 1e-15);
  CHECK(given.tangent_impulse.x < 0);
}

TEST_CASE("A ghost starts a cycle as the global step left it, driven against the load that it bore") {
  Bench bench(ghost_config());
  const double mass = 3, load_N = 20;
  bench.next_with({ball(1, {}, {{0, 0, -0.2}, {}})});
  REQUIRE(bench.snapshot->outside.try_push(outside(1 / mass)));
  REQUIRE(bench.snapshot->border.try_push(touch(0, 1 / mass)));
  bench.synchronise();
  bench.step(5);
  REQUIRE(ghost_of(bench).total_impulse.force.z < 0);
  bench.next({1});
  REQUIRE(bench.snapshot->outside.try_push(outside(1 / mass, {0, 0, -0.01})));
  REQUIRE(bench.snapshot->border.try_push(touch(load_N, 1 / mass)));
  bench.synchronise();
  CHECK(ghost_of(bench).velocity.linear == Vec3d{0, 0, -0.01});
  CHECK(ghost_of(bench).drive.linear.z == Approx(load_N / mass).epsilon(1e-12));
  CHECK(ghost_of(bench).total_impulse.force == Vec3d{});
}

TEST_CASE("A member in balance with an outside body stays there: the force is the global world's, without a ripple") {
  const double inverse_mass = GENERATE(0.0, 0.5, 2.0);
  SubWorldConfig config = ghost_config();
  config.step.gravity = {0, 0, -9.81};
  Bench bench(config);
  const double weight_N = kMass * 9.81;
  bench.next_with({ball(1, {})});
  for (int cycle = 0; cycle < 60; ++cycle) {
    REQUIRE(bench.snapshot->outside.try_push(outside(inverse_mass)));
    REQUIRE(bench.snapshot->border.try_push(touch(weight_N, 2)));
    bench.synchronise();
    for (int k = 0; k < 5; ++k) {
      bench.step();
      if (cycle < 30) continue;
      REQUIRE(bench.border(0).step_normal_impulse == Approx(weight_N * kTick_s).margin(1e-3 * kTick_s));
    }
    bench.next({1});
  }
  CHECK(norm(bench.motion(1).velocity.linear) < 1e-5);
}

TEST_CASE("The tank is never negative, and the border puts no more into the members than it may") {
  SubWorldConfig config = ghost_config();
  config.step.gravity = {0, 0, -9.81};
  Bench bench(config);
  // An outside body that claims to rise for ever, and of which the global world knows no work.
  bench.next_with({ball(1, {})});
  const double speed = 0.04;
  double most_in_tick_J = 0, before_J = 0;
  int spent_ticks = 0;
  for (int cycle = 0; cycle < 40; ++cycle) {
    OutsideBody body = outside(0, {0, 0, speed});
    body.centre.z += bench.is_member(1) && cycle > 0 ? bench.motion(1).pose.position.z : 0;
    BorderPoint point = touch(0, 2);
    point.outside_point.z = body.centre.z;
    REQUIRE(bench.snapshot->outside.try_push(body));
    REQUIRE(bench.snapshot->border.try_push(point));
    bench.synchronise();
    for (int k = 0; k < 5; ++k) {
      bench.step();
      const double work_J = bench.sub_world.border_work_J();
      most_in_tick_J = std::max(most_in_tick_J, work_J - before_J);
      before_J = work_J;
      REQUIRE(bench.sub_world.border_tank_J() >= 0);
      REQUIRE(((bench.last.status & kBorderSpent) != 0) == (bench.sub_world.border_tank_J() == 0));
      if ((bench.last.status & kBorderSpent) != 0) ++spent_ticks;
      REQUIRE(work_J <= 0.01 + most_in_tick_J);
    }
    bench.next({1});
  }
  CHECK(bench.sub_world.border_tank_J() == 0);
  CHECK(spent_ticks > 100);
  // It was carried up at first: m v^2 / 2 + m g z is what the tank held.
  const auto at_end = bench.motion(1);
  CHECK(kMass * 9.81 * at_end.pose.position.z <= 0.011);
  CHECK(at_end.pose.position.z > 1e-3);
}

TEST_CASE("While the world is late ghosts come to rest over r ticks") {
  Bench bench(ghost_config());
  bench.next_with({ball(1, {0, 0, 1})});  // far away
  REQUIRE(bench.snapshot->outside.try_push(outside(0.5, {0.1, 0, 0.2})));
  REQUIRE(bench.snapshot->border.try_push(touch(0, 2)));
  bench.synchronise();
  bench.step(4);
  CHECK(ghost_of(bench).velocity.linear.x == 0.1);
  for (int late = 0; late <= 5; ++late) {
    bench.step();
    CHECK(ghost_of(bench).velocity.linear.x == Approx(0.1 * (1 - late / 5.0)).margin(1e-15));
  }
  bench.step(20);
  CHECK((bench.last.status & kBorderFrozen) != 0);
}
