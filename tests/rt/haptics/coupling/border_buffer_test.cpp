// The buffer of a sub-world: the global world keeps its bodies' state, the sub-world that of the others.
#include "rt/haptics/coupling/border_buffer.h"

#include "tests/rt/haptics/coupling/sub_world_bench.h"

using namespace tactus;
using namespace tactus::test::sub_world_bench;

namespace {

SubWorldConfig ghost_config() {
  SubWorldConfig config = make_config();
  config.border_mode = physics::BorderMode::kGhost;
  return config;
}

// Balls 1 and 2, far apart; 2 is in the buffer.
Bench bench_with_buffer() {
  Bench bench(ghost_config());
  bench.next_with({ball(1, {}), ball(2, {1, 0, 0})});
  REQUIRE(bench.snapshot->buffer.try_push(2));
  bench.synchronise();
  bench.step(5);
  bench.next({1, 2});
  return bench;
}

}  // namespace

TEST_CASE("A buffer body takes the global world's state at a synchronisation, an inner member keeps its own") {
  Bench bench = bench_with_buffer();
  const physics::BodyMotion other{{{0.5, 0.25, -0.125}, {}}, {{0.005, 0, 0}, {0, 0, 2}}};
  const auto own = bench.motion(1);
  REQUIRE(bench.snapshot->renewed.try_push({1, 0, other}));  // no buffer body, and 5 mm/s is less than g T / 8
  REQUIRE(bench.snapshot->renewed.try_push({2, 0, other}));
  bench.synchronise();
  CHECK(bench.motion(2) == other);
  CHECK(bench.motion(1) == own);
  CHECK(bench.sub_world.buffer_bodies() == 0);
  const auto& body = bench.sub_world.world().bodies()[1];
  CHECK(bench.sub_world.buffer_gain_J() == Approx(kinetic_energy(body)).epsilon(1e-12));
}

TEST_CASE("The report lists the bodies whose state the global world keeps") {
  Bench bench = bench_with_buffer();
  bench.synchronise();
  REQUIRE(bench.report->members.size() == 2);
  CHECK(bench.report->members[0].in_buffer == 0);
  CHECK(bench.report->members[1].in_buffer == 1);
}

TEST_CASE("A buffer body that turns inner goes on from the global world's state and is the sub-world's from then on") {
  Bench bench = bench_with_buffer();
  const physics::BodyMotion other{{{0.5, 0, 0}, {}}, {{0.2, 0, 0}, {}}};
  REQUIRE(bench.snapshot->renewed.try_push({2, 0, other}));
  bench.synchronise();
  bench.step(5);
  const auto moved = bench.motion(2);
  CHECK(moved.pose.position.x == Approx(0.5 + 0.2 * 5 * kTick_s).epsilon(1e-9));
  bench.next({1, 2});
  REQUIRE(bench.snapshot->renewed.try_push({2, 0, other}));
  bench.synchronise();
  CHECK(bench.motion(2) == moved);
  CHECK(bench.report->members[1].in_buffer == 0);
}

// 10 mm/s is more than g T / 8, T: 5 ms: an inner member and a buffer body have hit each other in one of the worlds.
TEST_CASE("If an inner member's velocities differ by more than gravity explains all members take the global state") {
  const std::uint32_t late_ticks = GENERATE(0u, 1u);
  Bench bench = bench_with_buffer();
  bench.step(late_ticks);
  const physics::BodyMotion stopped{{{0.5, 0.25, 0}, {}}, {}}, moved{{{1.5, 0.25, 0}, {}}, {{0.01, 0, 0}, {0, 0, 1}}};
  const auto own = bench.motion(1);
  REQUIRE(bench.snapshot->renewed.try_push({1, 0, moved}));
  REQUIRE(bench.snapshot->renewed.try_push({2, 0, stopped}));
  bench.synchronise();
  CHECK(bench.motion(2) == stopped);
  CHECK(bench.motion(1) == (late_ticks == 0 ? moved : own));  // a late world's state is of another time
  CHECK(bench.report->members[0].in_buffer == (late_ticks == 0 ? 1u : 0u));
  CHECK(bench.report->members[1].in_buffer == 1);
}

TEST_CASE("The proxy takes the global state too and gets what the hand's impulse was beyond that in the global step") {
  Bench bench(ghost_config());
  bench.next_with({ball(kProxy, {}), ball(2, {1, 0, 0})});
  REQUIRE(bench.snapshot->buffer.try_push(2));
  bench.synchronise();
  bench.step(5, target_at({1e-3, 0, 0}));
  bench.next({kProxy, 2});
  const physics::BodyMotion global{{{-1e-3, 0, 0}, {}}, {{-0.5, 0.1, 0}, {}}};
  bench.snapshot->hand_impulse.force = {0.01, -0.02, 0};
  REQUIRE(bench.snapshot->renewed.try_push({kProxy, 0, global}));
  bench.synchronise();
  const Vec3d by_hand = 5 * kTick_s * bench.report->mean_device_wrench.force;
  REQUIRE(by_hand.x > 1e-3);
  const auto proxy = bench.motion(kProxy);
  check_close(proxy.velocity.linear,
              global.velocity.linear + (by_hand - bench.snapshot->hand_impulse.force) * (1 / kMass), 1e-12);
  CHECK(proxy.pose == global.pose);
  CHECK(bench.report->members[0].in_buffer == 0);
  CHECK(bench.report->members[0].motion == proxy);
  CHECK(bench.sub_world.proxy() == proxy);
}

namespace {

// The proxy, pressed by its weight on a slab in the buffer that nothing moves, for half a second.
Bench resting_on_slab(double friction) {
  SubWorldConfig config = ghost_config();
  config.step.gravity = {0, 0, -9.81};
  Bench bench(config);
  auto slab = physics::make_dynamic_body(5, physics::Shape::box({0.2, 0.2, 0.05}), 1000, friction, {});
  slab.gravity_scale = 0;
  auto proxy = ball(config.proxy, {0, 0, 0.05 + kRadius});
  proxy.friction = friction;
  bench.next_with({proxy, slab});
  REQUIRE(bench.snapshot->buffer.try_push(5));
  bench.synchronise();
  bench.step(500);
  bench.next({config.proxy, 5});
  return bench;
}

}  // namespace

TEST_CASE("The proxy goes with a buffer body that it holds on to by friction, along the surface") {
  const double friction = GENERATE(0.0, 0.5);
  Bench bench = resting_on_slab(friction);
  const Vec3d before = bench.motion(make_config().proxy).pose.position;
  auto moved = bench.motion(5);
  const Vec3d by{1e-4, -2e-4, 3e-4};
  moved.pose.position += by;
  REQUIRE(bench.snapshot->renewed.try_push({5, 0, moved}));
  bench.synchronise();
  const Vec3d carried = bench.motion(make_config().proxy).pose.position - before;
  const Vec3d along = friction > 0 ? Vec3d{by.x, by.y, 0} : Vec3d{};
  CHECK(norm(carried - along) < 1e-9);
  CHECK(bench.sub_world.proxy().pose.position == bench.motion(make_config().proxy).pose.position);
}

namespace {

// Two cubes on each other on the ground, at rest.
Bench two_cubes() {
  SubWorldConfig config = ghost_config();
  config.step.gravity = {0, 0, -9.81};
  Bench bench(config, {ground()});
  bench.next_with({cube(1, 0.05), cube(2, 0.15)});
  return bench;
}

// What the global world has at a contact of the sub-world: the same points, twice the load, and friction.
physics::WarmStart doubled(const physics::Contact& contact, double sub_step_s) {
  physics::WarmStart given = physics::World::warm_start_of(contact, sub_step_s);
  for (std::uint32_t i = 0; i < given.count; ++i) {
    given.normal_force[i] *= 2;
    given.friction_force[i] += Vec3d{0.3, -0.2, 0};
  }
  return given;
}

}  // namespace

TEST_CASE(
    "Contacts of buffer bodies begin a cycle with the global world's impulses, those with inner members in part") {
  Bench bench = two_cubes();
  REQUIRE(bench.snapshot->buffer.try_push(1));
  const bool both_in_buffer = GENERATE(false, true);
  if (both_in_buffer) REQUIRE(bench.snapshot->buffer.try_push(2));
  bench.synchronise();
  bench.step(200);
  bench.next({1, 2});
  const double sub_step_s = kTick_s / 4;
  const auto contacts = bench.sub_world.world().contacts();
  const std::vector<physics::Contact> before(contacts.begin(), contacts.end());
  REQUIRE(before.size() == 2);
  for (const auto& contact : before) REQUIRE(bench.snapshot->warm_starts.try_push(doubled(contact, sub_step_s)));
  bench.synchronise();
  for (std::size_t c = 0; c < 2; ++c) {
    const physics::Contact& now = bench.sub_world.world().contacts()[c];
    const double share = now.b_fixed || both_in_buffer ? 1 : 0.125;
    CAPTURE(now.b_fixed, both_in_buffer);
    REQUIRE(now.count == 4);
    for (std::uint32_t i = 0; i < now.count; ++i) {
      const auto [t1, t2] = tangents_of(now.normal);
      const auto &point = now.points[i], &was = before[c].points[i];
      CHECK(point.normal_impulse == Approx((1 + share) * was.normal_impulse));
      const Vec3d added = share * sub_step_s * Vec3d{0.3, -0.2, 0};
      CHECK(point.tangent_impulse[0] == Approx(was.tangent_impulse[0] + dot(added, t1)));
      CHECK(point.tangent_impulse[1] == Approx(was.tangent_impulse[1] + dot(added, t2)));
    }
  }
}

TEST_CASE("A saved buffer comes back, and bytes that are no buffer of these bodies are refused") {
  Bench bench = bench_with_buffer();
  haptics::BorderBuffer buffer;
  auto snapshot = std::make_unique<haptics::WorldSnapshot>();
  REQUIRE(snapshot->buffer.try_push(1));
  REQUIRE(snapshot->buffer.try_push(2));
  physics::World world(bench.sub_world.config().capacities);
  for (const auto& body : bench.sub_world.world().bodies()) REQUIRE(world.insert(body));
  (void)buffer.adopt(*snapshot, {.proxy = make_config().proxy, .duration_s = 0, .hand_impulse = {}}, world);
  std::vector<std::byte> bytes(haptics::BorderBuffer::kMaxBytes);
  ByteWriter out(bytes);
  buffer.save(out);
  REQUIRE(out.ok());
  haptics::BorderBuffer again;
  ByteReader in(std::span<const std::byte>(bytes).first(out.size()));
  REQUIRE(again.restore(in, world));
  CHECK(again.size() == 2);
  CHECK(again.holds(2));
  REQUIRE(world.remove(2));
  ByteReader no_such_body(std::span<const std::byte>(bytes).first(out.size()));
  CHECK_FALSE(again.restore(no_such_body, world));
  ByteReader cut(std::span<const std::byte>(bytes).first(out.size() - 1));
  CHECK_FALSE(again.restore(cut, world));
}
