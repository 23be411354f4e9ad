// The ghost border of a sub-world: what crosses the border in a cycle, and how it is accounted for.
#include "rt/base/status.h"
#include "rt/haptics/coupling/border_correction.h"
#include "tests/rt/haptics/coupling/sub_world_bench.h"

using namespace tactus;
using namespace tactus::test::sub_world_bench;
using haptics::OutsideBody;

namespace {

SubWorldConfig ghost_config() {
  SubWorldConfig config = make_config();
  config.border_mode = physics::BorderMode::kGhost;
  return config;
}

// `load_N`: what its other forces stand up to, downwards.
OutsideBody outside(double inverse_mass, const Vec3d& velocity = {}, double load_N = 0) {
  OutsideBody body;
  body.id = kOutside;
  body.centre = {0, 0, -kRadius};
  body.velocity.linear = velocity;
  body.admittance.linear = SymMat3d::identity(inverse_mass);
  body.drive.linear = {0, 0, inverse_mass * load_N};
  return body;
}

BorderPoint touch(double force_N, double inverse_mass, double friction = 0) {
  BorderPoint point = support(1, force_N, friction);
  point.member_anchor = {0, 0, -kRadius};
  point.outside_point = {0, 0, -kRadius};
  point.outside_inverse_mass = inverse_mass;
  return point;
}

const physics::BorderGhost& ghost_of(const Bench& bench) { return bench.sub_world.world().border_ghosts()[0]; }

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
  CHECK(lost.x > 0);  // by friction
  CHECK(bench.report->border.empty());
  REQUIRE(bench.report->outside.size() == 1);
  CHECK(bench.report->outside[0].id == kOutside);
  check_close(bench.report->outside[0].impulse.force, lost, 1e-15);
}

TEST_CASE("A ghost's contact begins a cycle with the global step's impulses, and one that did not press with its own") {
  Bench bench(ghost_config());
  const double mass = 3, sub_step_s = kTick_s / 4;
  bench.next_with({ball(1, {}, {{0.1, 0, -0.2}, {}})});
  REQUIRE(bench.snapshot->outside.try_push(outside(1 / mass)));
  REQUIRE(bench.snapshot->border.try_push(touch(0, 1 / mass, 0.3)));
  bench.synchronise();
  bench.step();
  const auto impulse_of = [](const physics::BorderContact& contact) {
    const auto [t1, t2] = tangents_of(contact.normal);
    return contact.normal_impulse * contact.normal + contact.tangent_impulse[0] * t1 + contact.tangent_impulse[1] * t2;
  };
  const Vec3d own_Ns = impulse_of(bench.border(0));
  const bool pressed = GENERATE(false, true);
  bench.next({1});
  REQUIRE(bench.snapshot->outside.try_push(outside(1 / mass)));
  BorderPoint point = touch(pressed ? 8 : 0, 1 / mass, 0.3);
  point.friction_N = {1, -2, 0};
  REQUIRE(bench.snapshot->border.try_push(point));
  bench.synchronise();
  check_close(impulse_of(bench.border(0)), pressed ? sub_step_s * Vec3d{1, -2, 8} : own_Ns, 1e-15);
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
  REQUIRE(bench.snapshot->outside.try_push(outside(1 / mass, {0, 0, -0.01}, load_N)));
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
    REQUIRE(bench.snapshot->outside.try_push(outside(inverse_mass, {}, weight_N)));
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

namespace {

// Outside bodies with a wrong motion in the snapshot: the reported velocity and drive. The bodies rest.
struct Lie {
  const char* name;
  Twistd velocity, drive;
};
const Lie kLies[] = {
    {"rises", {{0, 0, 0.5}, {}}, {}},
    {"slides away below", {{0.5, 0, 0}, {}}, {}},
    {"spins below", {{}, {10, 0, 0}}, {}},
    {"is driven upwards", {}, {{0, 0, 40}, {}}},
    {"is driven sideways", {}, {{200, 0, 0}, {}}},
    {"rises and slides", {{0.4, 0.2, 0.3}, {0, 5, 0}}, {{5, 5, 10}, {}}},
};
constexpr double kFullTank_J = 0.01;
constexpr int kLiedTicks = 200;

struct Lied {
  double most_J{0};         // largest energy that ghosts had put in
  double most_in_empty{0};  // same, in ticks that began with nothing in the tank
  double pushed_J{0};       // energy that push-out took from members in cycles in which it took some
  int spent_ticks{0};
};

// A ball on another, and a third beside them, all on the outside body, which each snapshot puts below them.
Lied tell(const Lie& lie, double admitted_work_J) {
  SubWorldConfig config = ghost_config();
  config.step.gravity = {0, 0, -9.81};
  Bench bench(config);
  bench.next_with({ball(1, {}), ball(2, {0, 0, 2 * kRadius}), ball(3, {0.3, 0, 0})});
  Lied lied;
  double before_J = 0;
  for (int cycle = 0; cycle < kLiedTicks / 5; ++cycle) {
    REQUIRE(bench.snapshot->outside.try_push(outside(0, lie.velocity.linear)));
    bench.snapshot->outside[0].velocity = lie.velocity;
    bench.snapshot->outside[0].centre = {0, 0, -2 * kRadius};
    bench.snapshot->outside[0].drive = lie.drive;
    for (const BodyId id : {1u, 3u}) {
      BorderPoint point = touch(0, 2, 0.8);
      point.member = id;
      const auto motion = cycle == 0 ? (id == 1 ? ball(1, {}) : ball(3, {0.3, 0, 0})).motion : bench.motion(id);
      point.member_anchor = rotate_inverse(motion.pose.rotation, Vec3d{0, 0, -kRadius});
      point.outside_point = motion.pose.position - Vec3d{0, 0, kRadius};
      REQUIRE(bench.snapshot->border.try_push(point));
    }
    bench.snapshot->border_work_J = admitted_work_J;
    bench.synchronise();
    const double pushed_J = bench.sub_world.push_out_J();
    for (int k = 0; k < 5; ++k) {
      const bool empty = bench.sub_world.border_tank_J() == 0;
      const double owed_J = bench.sub_world.border_owed_J();
      bench.step(1, {}, 1);  // one sub-step: that is how often the tank is looked at
      const double work_J = bench.sub_world.border_work_J();
      lied.most_J = std::max(lied.most_J, work_J);
      if (empty) lied.most_in_empty = std::max(lied.most_in_empty, work_J - before_J);
      if ((bench.last.status & kBorderSpent) != 0) ++lied.spent_ticks;
      before_J = work_J;
      REQUIRE(bench.sub_world.border_tank_J() >= 0);
      REQUIRE(bench.sub_world.border_owed_J() <= owed_J + 1e-12);  // a tick never adds to what is owed
      REQUIRE(((bench.last.status & kBorderSpent) != 0) == (bench.sub_world.border_tank_J() <= 0.01 * kFullTank_J));
    }
    lied.pushed_J += std::max(0.0, pushed_J - bench.sub_world.push_out_J());
    bench.next({1, 2, 3});
  }
  return lied;
}

}  // namespace

TEST_CASE("Whatever an outside body does, the impulses of its ghost give members no more energy than the tank holds") {
  for (const Lie& lie : kLies) {
    CAPTURE(lie.name);
    const Lied lied = tell(lie, 0);
    CHECK(lied.most_J <= (kFullTank_J + lied.pushed_J) * (1 + 1e-9));
    CHECK(lied.pushed_J < kFullTank_J);
    CHECK(lied.spent_ticks > 10);
    // The tank limits the ghost: with work credited by the global world the ghost puts in far more.
    CHECK(tell(lie, 0.05).most_J > 2 * lied.most_J);
  }
}

TEST_CASE("With nothing in its tank the border only takes, along the normal and by friction") {
  for (const Lie& lie : kLies) {
    CAPTURE(lie.name);
    const Lied lied = tell(lie, -0.001);  // the global world reports work by members
    CHECK(lied.spent_ticks > 10);
    CHECK(lied.most_in_empty <= 1e-9 * kFullTank_J);
  }
}

TEST_CASE("What outside bodies did in the global step is the tank's at the synchronisation, with sign, once") {
  Bench bench(ghost_config());
  bench.next_with({ball(1, {0, 0, 1})});
  bench.snapshot->border_work_J = -7;  // before there were members
  bench.synchronise();
  CHECK(bench.sub_world.border_tank_J() == kFullTank_J);
  bench.step(5);
  bench.next({1});
  bench.snapshot->border_work_J = 0.02;
  bench.synchronise();
  CHECK(bench.sub_world.border_tank_J() == Approx(kFullTank_J + 0.02));
  CHECK(bench.report->border_tank_J == Approx(kFullTank_J + 0.02));
  bench.step(10);  // late by five ticks
  CHECK(bench.sub_world.border_tank_J() == Approx(kFullTank_J + 0.02));
  bench.next({1});
  bench.snapshot->border_work_J = -0.05;
  bench.synchronise();
  CHECK(bench.sub_world.border_tank_J() == 0);
  CHECK(bench.sub_world.border_owed_J() == Approx(0.02));
  CHECK(bench.report->border_tank_J == Approx(-0.02));
}

TEST_CASE("A load that sinks into a ghost pays with its weight at the synchronisation, with no velocity at any tick") {
  SubWorldConfig config = ghost_config();
  config.step.gravity = {0, 0, -9.81};
  Bench bench(config);
  bench.next_with({ball(1, {})});
  for (int cycle = 0; cycle < 3; ++cycle) {
    REQUIRE(bench.snapshot->outside.try_push(outside(0)));
    bench.snapshot->outside[0].centre = {0, 0, -2 * kRadius};
    BorderPoint point = touch(kMass * 9.81, 2);
    point.outside_point = {0, 0, -kRadius};
    REQUIRE(bench.snapshot->border.try_push(point));
    bench.synchronise();
    const double tank_J = bench.sub_world.border_tank_J(), before_m = bench.motion(1).pose.position.z;
    const double worked_J = bench.sub_world.border_work_J();
    bench.step(5);
    const double sunk_m = before_m - bench.motion(1).pose.position.z;
    const double v = norm(bench.motion(1).velocity.linear);
    bench.next({1});
    if (cycle < 2) continue;
    bench.synchronise();
    CHECK(sunk_m > 0);
    CHECK(kMass * v * v < 1e-3 * kMass * 9.81 * sunk_m);
    CHECK(bench.sub_world.border_work_J() - worked_J > -0.5 * kMass * 9.81 * sunk_m);  // velocities do not tell
    CHECK(bench.sub_world.border_tank_J() - tank_J == Approx(kMass * 9.81 * sunk_m).epsilon(0.02));
  }
}

TEST_CASE("The tank pays what corrections give to members, and gets what they take") {
  SubWorldConfig config = ghost_config();
  config.step.gravity = {0, 0, -9.81};
  for (const double up : {1.0, -1.0}) {
    Bench bench(config);
    bench.next_with({ball(1, {0, 0, 1})});
    bench.synchronise();
    bench.step(5);
    const BodyMotion before = bench.sub_world.world().find(1)->motion;
    BodyMotion after = before;
    after.pose.position.z += up * 1e-3;
    after.velocity.linear.z += up * 0.02;
    bench.next({1});
    REQUIRE(bench.snapshot->corrections.try_push(haptics::correction_between(1, before, after)));
    bench.synchronise();
    const double v0 = before.velocity.linear.z, v1 = after.velocity.linear.z;
    const double given_J = kMass * (0.5 * (v1 * v1 - v0 * v0) + 9.81 * up * 1e-3);
    CHECK(bench.sub_world.corrected_J() == Approx(given_J));
    // Semi-implicit Euler loses m g^2 h^2 / 2 a sub-step in free fall: dissipated, so it fills a tank that has room.
    const double h = config.step.dt / config.step.sub_steps;
    const double lost_J = 5 * config.step.sub_steps * 0.5 * kMass * 9.81 * 9.81 * h * h;
    CHECK(bench.sub_world.border_tank_J() == Approx(kFullTank_J - given_J + (given_J > 0 ? lost_J : 0)));
  }
}

TEST_CASE("What members dissipate between them fills the tank") {
  Bench bench(ghost_config());
  Body resting = ball(1, {0, 0, 1}), meets = ball(2, {3 * kRadius, 0, 1});
  meets.motion.velocity.linear = {-1, 0, 0};
  bench.next_with({resting, meets});
  bench.synchronise();
  bench.step(5);
  bench.next({1, 2});
  bench.snapshot->border_work_J = -kFullTank_J;
  bench.synchronise();
  CHECK(bench.sub_world.border_tank_J() == Approx(0).margin(1e-12));
  bench.snapshot->border_work_J = 0;
  for (int cycle = 0; cycle < 20; ++cycle) {  // they meet, and go on together: half of the kinetic energy is lost
    bench.step(5);
    bench.next({1, 2});
    bench.synchronise();
  }
  CHECK(norm(bench.motion(1).velocity.linear - bench.motion(2).velocity.linear) < 0.1);
  CHECK(bench.sub_world.border_tank_J() == Approx(kFullTank_J));
}

TEST_CASE("A filtered replay pushes as a replay while its tank lasts, and puts no more in than that") {
  const double push_N = 3 * kMass * 9.81;
  constexpr double kGiven_J = 0.02;  // by the outside body in the global step before the first cycle
  for (const auto mode : {physics::BorderMode::kReplay, physics::BorderMode::kFiltered}) {
    SubWorldConfig config = make_config();
    config.border_mode = mode;
    config.step.gravity = {0, 0, -9.81};
    Bench bench(config);
    bench.next_with({ball(1, {})});
    double most_J = 0;
    for (int cycle = 0; cycle < 40; ++cycle) {
      REQUIRE(bench.snapshot->border.try_push(support(1, push_N)));
      bench.snapshot->border_work_J = cycle == 0 ? kGiven_J : 0;
      bench.synchronise();
      for (int k = 0; k < 5; ++k) {
        bench.step();
        most_J = std::max(most_J, bench.sub_world.border_work_J());
        if (cycle == 0) CHECK(bench.border(0).step_normal_impulse == Approx(push_N * kTick_s));
      }
      bench.next({1});
    }
    // Replayed, it flies off at 2 g: v = 2 g t, z = g t^2, and the work is 3 m g z.
    const double t = 40 * 5 * kTick_s, replayed_J = push_N * 9.81 * t * t;
    if (mode == physics::BorderMode::kReplay)
      CHECK(most_J == Approx(replayed_J).epsilon(0.01));
    else
      CHECK(most_J <= kGiven_J * (1 + 1e-9));
  }
}

TEST_CASE("A filtered replay gets the global step's work tick by tick, and none while the world is late") {
  SubWorldConfig config = make_config();
  config.border_mode = physics::BorderMode::kFiltered;
  config.step.gravity = {0, 0, -9.81};
  Bench bench(config);
  bench.next_with({ball(1, {})});
  REQUIRE(bench.snapshot->border.try_push(support(1, kMass * 9.81)));  // the ball rests: the border does no work
  constexpr double kGiven_J = 0.02;
  bench.snapshot->border_work_J = kGiven_J;
  bench.synchronise();
  CHECK(bench.sub_world.border_tank_J() == 0);
  for (int tick = 1; tick <= 8; ++tick) {
    bench.step();
    CHECK(bench.sub_world.border_tank_J() == Approx(kGiven_J * std::min(tick, 5) / 5).epsilon(1e-6));
  }
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
