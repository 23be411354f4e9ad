#include "rt/haptics/sub_world.h"

#include <catch2/catch.hpp>
#include <cstring>
#include <memory>
#include <vector>

#include "rt/base/status.h"
#include "tests/support/physics_bench.h"
#include "tests/support/rt_guard.h"

using namespace tactus;
using namespace tactus::haptics;
using physics::Body;
using physics::BodyMotion;
using physics::BorderMode;
using physics::Shape;
using test::kGravity;

namespace {

constexpr BodyId kProxy = 0, kGround = 50, kOutside = 90;
constexpr double kTick_s = 1e-3, kMass = 0.5, kRadius = 0.05;

SubWorldConfig make_config(CouplingScheme scheme = CouplingScheme::kSubWorld) {
  SubWorldConfig config;
  config.scheme = scheme;
  config.ratio = 5;
  config.proxy = kProxy;
  config.step.dt = kTick_s;
  config.capacities = {.bodies = 16, .fixed_bodies = 4, .pairs = 64, .contacts = 64, .border_contacts = 8};
  return config;
}

Body<double> ball(BodyId id, const Vec3d& at, const Twistd& velocity = {}) {
  auto body = physics::make_dynamic_body<double>(id, Shape<double>::sphere(kRadius), kMass, 0.5, {at, {}});
  body.motion.velocity = velocity;
  return body;
}

Body<double> cube(BodyId id, double height) {
  return physics::make_dynamic_body<double>(id, Shape<double>::box({0.05, 0.05, 0.05}), kMass, 0.5,
                                            {{0, 0, height}, {}});
}

Body<double> ground() { return physics::make_fixed_body<double>(kGround, Shape<double>::plane(), 0.5, {}); }

// A border point at the foot of a ball, where it stands on an outside body whose surface is z = 0: it pushes up and
// turns nothing.
BorderPoint support(BodyId member, double force_N, double friction = 0, std::uint32_t feature = 7) {
  BorderPoint point;
  point.member = member, point.outside = kOutside, point.feature = feature;
  point.normal = {0, 0, 1};
  point.member_anchor = {0, 0, -kRadius};
  point.impulse_rate_N = force_N;
  point.friction = friction;
  return point;
}

// A sub-world, the snapshot that it gets next and the report that it gave last.
struct Bench {
  explicit Bench(const SubWorldConfig& config, std::vector<Body<double>> fixed = {}) : sub_world(config, fixed) {}

  SubWorld sub_world;
  std::unique_ptr<WorldSnapshot> snapshot = std::make_unique<WorldSnapshot>();
  std::unique_ptr<SubWorldReport> report = std::make_unique<SubWorldReport>();
  SubWorldStep last;
  std::uint64_t cycle{0};

  // Clears what the snapshot says but for the members.
  WorldSnapshot& next(std::vector<BodyId> members) {
    snapshot->members.clear(), snapshot->joiners.clear(), snapshot->warm_starts.clear(), snapshot->border.clear();
    for (const BodyId id : members) REQUIRE(snapshot->members.try_push(id));
    return *snapshot;
  }
  WorldSnapshot& next_with(std::vector<Body<double>> joiners) {
    next({});
    for (const auto& body : joiners) {
      REQUIRE(snapshot->members.try_push(body.id));
      REQUIRE(snapshot->joiners.try_push(body));
    }
    return *snapshot;
  }
  void synchronise() {
    snapshot->cycle = cycle++;
    sub_world.synchronise(*snapshot, *report);
  }
  void step(std::uint32_t ticks = 1, const DeviceTarget& target = {}, std::uint32_t sub_steps = 4) {
    for (std::uint32_t i = 0; i < ticks; ++i) last = sub_world.step(target, sub_steps, {});
  }
  BodyMotion<double> motion(BodyId id) const {
    const std::int32_t slot = sub_world.world().slot_of(id);
    REQUIRE(slot >= 0);
    return sub_world.world().bodies()[static_cast<std::size_t>(slot)].motion;
  }
  bool is_member(BodyId id) const { return sub_world.world().slot_of(id) >= 0; }
  const physics::BorderContact<double>& border(std::uint32_t i) const { return sub_world.world().border_contacts()[i]; }
};

bool same_bits(const BodyMotion<double>& a, const BodyMotion<double>& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

void check_close(const Vec3d& a, const Vec3d& b, double within) {
  CAPTURE(a.x, a.y, a.z, b.x, b.y, b.z);
  CHECK(norm(a - b) <= within);
}

DeviceTarget target_at(const Vec3d& position, const Quatd& rotation = {}) { return {true, {position, rotation}, {}}; }

}  // namespace

TEST_CASE("a synchronisation reports what was, leavers included, and only then takes over what is new") {
  Bench bench(make_config());
  bench.next_with({ball(0, {0, 0, 0}, {{0.1, 0, 0}, {1, 2, 3}}), ball(1, {1, 0, 0}, {{0, 0.2, 0}, {0, 1, 0}}),
                   ball(2, {2, 0, 0}, {{0, 0, 0.3}, {}})});
  bench.synchronise();
  CHECK(bench.report->cycle == 0);
  CHECK(bench.report->ticks == 0);
  CHECK(bench.report->members.empty());
  bench.step(3);
  const BodyMotion<double> before[] = {bench.motion(0), bench.motion(1), bench.motion(2)};

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

TEST_CASE("a member that stays is never overwritten, whatever the snapshot says of it") {
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

  const auto sum_of = [](const physics::WarmStart<double>& w) {
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
  config.step.gravity = {0, 0, -kGravity};
  const auto settle = [&](Bench& bench) {
    bench.next_with({ball(0, {5, 0, 5}), cube(1, 0.05), cube(2, 0.15)});
    bench.snapshot->joiners[0].gravity_scale = 0;
    bench.synchronise();
    bench.step(400);
  };
  Bench stays(config, {ground()}), returns(config, {ground()});
  settle(stays), settle(returns);
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
    stays.step(20), returns.step(20);
    check_close(stays.motion(2).pose.position, returns.motion(2).pose.position, 1e-12);
    check_close(stays.motion(2).velocity.linear, returns.motion(2).velocity.linear, 1e-12);
  }
  SECTION("without it it does not: the comparison can tell") {
    returns.synchronise();
    stays.step(20), returns.step(20);
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
      felt.force += bench.last.on_device.force, felt.torque += bench.last.on_device.torque;
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

TEST_CASE("the work of the border is booked over all cycles: on a free body it is the kinetic energy gained") {
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

TEST_CASE("border contacts beyond the capacity are left out, counted and said once") {
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
    bench.step();
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

TEST_CASE("interpolation: the proxy goes evenly from one global state to the next in a cycle, and waits there") {
  const SubWorldConfig config = make_config(CouplingScheme::kInterpolation);
  Bench bench(config);
  const Posed from{{0.1, 0.2, 0.3}, quat_from_rotation_vector(Vec3d{0.5, 0, 0.1})};
  const Quatd turn = quat_from_rotation_vector(Vec3d{0.03, -0.05, 0.04});
  const Posed to{{0.11, 0.19, 0.32}, turn * from.rotation};
  bench.next({});
  bench.snapshot->proxy = {from, {}};
  bench.synchronise();
  CHECK(bench.sub_world.proxy().pose == from);
  bench.step(config.ratio);
  CHECK(norm(bench.sub_world.proxy().pose.position - from.position) <= 1e-15);
  CHECK(bench.sub_world.proxy().velocity == Twistd{});

  // A quaternion and its negative are the same turn.
  const bool flipped = GENERATE(false, true);
  const Quatd& q = to.rotation;
  bench.snapshot->proxy = {{to.position, flipped ? Quatd{-q.w, -q.x, -q.y, -q.z} : q}, {}};
  bench.synchronise();
  const double cycle_s = config.ratio * kTick_s;
  for (std::uint32_t i = 1; i <= config.ratio; ++i) {
    bench.step();
    const double share = static_cast<double>(i) / config.ratio;
    const auto& proxy = bench.sub_world.proxy();
    check_close(proxy.pose.position, from.position + share * (to.position - from.position), 1e-15);
    const Quatd turned = proxy.pose.rotation * conjugate(from.rotation);
    check_close(small_rotation_vector(turned), share * small_rotation_vector(turn), 1e-5);
    check_close(proxy.velocity.linear, (1 / cycle_s) * (to.position - from.position), 1e-12);
    check_close(proxy.velocity.angular, (1 / cycle_s) * Vec3d{0.03, -0.05, 0.04}, 1e-2);
  }
  for (int i = 0; i < 7; ++i) {
    const auto& proxy = bench.sub_world.proxy();
    check_close(proxy.pose.position, to.position, 1e-15);
    check_close(small_rotation_vector(proxy.pose.rotation * conjugate(to.rotation)), {}, 1e-15);
    bench.step();
    CHECK(proxy.velocity == Twistd{});
    CHECK((bench.last.status & kWorldLate) != 0);
  }
}

TEST_CASE("interpolation: the effort of a cycle is stored, reported once, and nothing is imposed") {
  const SubWorldConfig config = make_config(CouplingScheme::kInterpolation);
  Bench bench(config);
  bench.next_with({ball(kProxy, {})});
  bench.synchronise();
  bench.next({kProxy});
  bench.snapshot->proxy.pose.position = {0.01, 0, 0};
  bench.synchronise();
  const Vec3d rotated{0, 0, 0.02}, at{0.02, 0, 0}, velocity{0, 0.1, 0};
  const DeviceTarget target{true, {at, quat_from_rotation_vector(rotated)}, {velocity, {}}};
  Vec3d force_sum;
  for (std::uint32_t i = 1; i <= config.ratio; ++i) {
    bench.step(1, target);
    const Vec3d proxy{0.01 * i / config.ratio, 0, 0}, proxy_velocity{0.01 / (config.ratio * kTick_s), 0, 0};
    const Vec3d force = config.stiffness_N_per_m * (at - proxy) + config.damping_Ns_per_m * (velocity - proxy_velocity);
    force_sum += force;
    check_close(bench.last.on_device.force, -force, 1e-9);
    check_close(bench.last.on_device.torque, -config.stiffness_Nm_per_rad * rotated, 1e-5);
  }
  bench.synchronise();
  check_close(bench.report->stored_effort.force, kTick_s * force_sum, 1e-12);
  check_close(bench.report->stored_effort.torque, (config.ratio * kTick_s * config.stiffness_Nm_per_rad) * rotated,
              1e-6);
  CHECK(bench.report->members.empty());
  CHECK(bench.report->border.empty());
  CHECK(bench.report->mean_device_wrench == Wrenchd{});
  bench.step(2);  // not engaged: no effort
  bench.synchronise();
  CHECK(bench.report->stored_effort == Wrenchd{});
}

TEST_CASE("static: only the proxy moves, the others keep their bits though pushed, and only the proxy is reported") {
  SubWorldConfig config = make_config(CouplingScheme::kStatic);
  config.step.gravity = {0, 0, -kGravity};
  Bench bench(config, {ground()});
  auto proxy = ball(kProxy, {0, 0, 0.2 + kRadius + 1e-3});
  proxy.gravity_scale = 0;
  auto frozen = cube(1, 0.15);
  frozen.motion.velocity = {{0.1, 0, 0}, {0, 0, 1}};
  bench.next_with({proxy, frozen, cube(2, 1.0)});
  bench.synchronise();
  const auto falling = bench.motion(2);
  for (std::uint32_t i = 0; i < 200; ++i) bench.step(1, target_at({0, 0, 0.2 + kRadius - 2e-3}));
  CHECK(same_bits(bench.motion(1), frozen.motion));
  CHECK(same_bits(bench.motion(2), falling));
  CHECK((bench.last.status & kProxyContact) != 0);
  // It rests on the frozen cube, and the hand carries the spring.
  CHECK(bench.last.on_device.force.z == Approx(config.stiffness_N_per_m * 2e-3).epsilon(0.05));
  CHECK(std::abs(bench.motion(kProxy).pose.position.z - 0.2 - kRadius) < 1e-4);

  const auto held = bench.motion(kProxy);
  auto moved = frozen;
  moved.motion.pose.position.x = 1.0 / 3;
  bench.next_with({proxy, moved, cube(2, 0.9)});
  bench.synchronise();
  REQUIRE(bench.report->members.size() == 1);
  CHECK(bench.report->members[0].id == kProxy);
  CHECK(same_bits(bench.report->members[0].motion, held));
  CHECK(same_bits(bench.motion(kProxy), held));
  CHECK(same_bits(bench.motion(1), moved.motion));
  CHECK(bench.motion(2).pose.position.z == 0.9);
  bench.step(3);
  CHECK(same_bits(bench.motion(1), moved.motion));
}

TEST_CASE("direct: the dynamic bodies given are members, and nothing is ever late") {
  SubWorldConfig config = make_config(CouplingScheme::kDirect);
  config.step.gravity = {0, 0, -kGravity};
  Bench bench(config, {ground()});
  const std::vector<Body<double>> bodies{ground(), ball(3, {0, 0, 1}), ball(kProxy, {1, 0, 1})};
  bench.sub_world.set_members(bodies);
  CHECK(bench.sub_world.members() == 2);
  CHECK_FALSE(bench.sub_world.exchanges());
  CHECK(bench.sub_world.proxy().pose.position == Vec3d{1, 0, 1});
  for (int i = 0; i < 300; ++i) {
    bench.step();
    REQUIRE((bench.last.status & (kWorldLate | kBorderFrozen | kWorldFade)) == 0);
    REQUIRE(bench.last.force_scale == 1);
  }
  // 300 ticks of four sub-steps: x(n) = -g h^2 n (n + 1) / 2.
  const double h = kTick_s / 4;
  CHECK(bench.motion(3).pose.position.z == Approx(1 - kGravity * h * h * 1200 * 1201 / 2).epsilon(1e-12));
}

namespace {

// A stack with a border on top, pressed by the proxy; a synchronisation every eighth tick, so the world is often late.
struct Busy : Bench {
  static SubWorldConfig busy_config() {
    SubWorldConfig config = make_config();
    config.step.gravity = {0, 0, -kGravity};
    return config;
  }
  Busy() : Bench(busy_config(), {ground()}) {}

  void begin() {
    auto proxy = ball(kProxy, {0, 0, 0.3 + kRadius});
    proxy.gravity_scale = 0;
    next_with({proxy, cube(1, 0.05), cube(2, 0.15), cube(3, 0.25)});
    add_border();
    synchronise();
  }
  void add_border() {
    BorderPoint side = support(2, 4, 0.3);
    side.normal = {1, 0, 0};
    side.member_anchor = {-0.05, 0.01, 0.02};
    side.outside_velocity = {0.01, 0.02, 0};
    REQUIRE(snapshot->border.try_push(side));
    REQUIRE(snapshot->border.try_push(support(3, 1, 0.3)));
  }
  void tick(std::uint32_t t) {
    if (t % 8 == 7) {
      next({kProxy, 1, 2, 3});
      add_border();
      synchronise();
    }
    const double swing = 1e-4 * static_cast<double>(t % 13);
    step(1, {true, {{swing, 0, 0.3 + kRadius - 1e-3 - swing}, {}}, {{0.01, 0, 0}, {}}}, 2 + t % 3);
  }
};

}  // namespace

TEST_CASE("a sub-world restored in the middle of a cycle goes on bit by bit") {
  Busy original;
  original.begin();
  for (std::uint32_t t = 0; t < 27; ++t) original.tick(t);
  REQUIRE(original.sub_world.ticks_in_cycle() == 4);
  REQUIRE(original.sub_world.border_contacts() == 2);
  std::vector<std::byte> bytes(original.sub_world.save_size_bound());
  ByteWriter out(bytes);
  original.sub_world.save(out);
  REQUIRE(out.ok());
  bytes.resize(out.size());

  Busy copy;
  ByteReader in(bytes);
  REQUIRE(copy.sub_world.restore(in));
  CHECK(in.remaining() == 0);
  CHECK(copy.sub_world.state_hash() == original.sub_world.state_hash());
  CHECK(copy.sub_world.border_contacts() == 2);
  CHECK(copy.sub_world.border_work_J() == original.sub_world.border_work_J());
  for (std::uint32_t t = 27; t < 90; ++t) {
    original.tick(t), copy.tick(t);
    CAPTURE(t);
    REQUIRE(copy.sub_world.state_hash() == original.sub_world.state_hash());
    REQUIRE(std::memcmp(&copy.last.on_device, &original.last.on_device, sizeof(Wrenchd)) == 0);
    REQUIRE(copy.last.status == original.last.status);
    REQUIRE(copy.sub_world.border_work_J() == original.sub_world.border_work_J());
    REQUIRE(copy.report->ticks == (t < 31 ? 0 : original.report->ticks));
    if (t < 31) continue;
    REQUIRE(copy.report->mean_device_wrench == original.report->mean_device_wrench);
    REQUIRE(copy.report->border[0].tangent_impulse == original.report->border[0].tangent_impulse);
  }
}

TEST_CASE("bytes that are cut short are no sub-world") {
  Busy original;
  original.begin();
  for (std::uint32_t t = 0; t < 12; ++t) original.tick(t);
  std::vector<std::byte> bytes(original.sub_world.save_size_bound());
  ByteWriter out(bytes);
  original.sub_world.save(out);
  Busy copy;
  for (std::size_t size = 0; size < out.size(); size += 3) {
    ByteReader in(std::span<const std::byte>(bytes).first(size));
    REQUIRE_FALSE(copy.sub_world.restore(in));
  }
}

TEST_CASE("a synchronisation and a tick neither allocate nor lock") {
  Busy busy;
  busy.begin();
  busy.next({kProxy, 1, 2});
  busy.add_border();
  const test::RtGuard guard;
  busy.synchronise();
  busy.step(3, target_at({0, 0, 0.3}));
  const auto allocations = guard.allocations(), locks = guard.locks();
  CHECK(allocations == 0);
  CHECK(locks == 0);
}
