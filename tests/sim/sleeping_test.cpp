// The effect sleeping in the global world: which bodies fall asleep, what wakes them, and that neither makes a jump.
#include "sim/loader/generators.h"
#include "tests/sim/global_world_bench.h"

namespace {

using namespace tactus;
using namespace tactus::sim;
using haptics::SubWorldReport;
using haptics::WorldSnapshot;
using physics::Shape;
using Bench = test::GlobalWorldBench;

constexpr double kHalf_m = 0.05, kMass_kg = 0.2, kGravity = 9.81;
constexpr std::uint32_t kSlowSteps = 50;  // 0.5 s by steps of 10 ms

// A proxy that floats ten metres above the ground; stacks are added on the ground.
struct Builder {
  Scene scene;
  Builder() {
    scene.effects = {true, true, false, true};
    scene.proxy = 0;
    add(physics::make_dynamic_body(0, Shape::sphere(0.02), 0.2, 0.5, {{0, 0, 10}, {}}));
    scene.bodies[0].gravity_scale = 0;
    add(physics::make_fixed_body(1, Shape::plane(), 0.5, {}));
  }
  BodyId add(physics::Body body) {
    body.id = static_cast<BodyId>(scene.bodies.size());
    scene.bodies.push_back(body);
    return body.id;
  }
  BodyId add_stack(double x, unsigned cubes) {
    BodyId last = 0;
    for (unsigned k = 0; k < cubes; ++k)
      last = add(physics::make_dynamic_body(0, Shape::box({kHalf_m, kHalf_m, kHalf_m}), kMass_kg, 0.5,
                                            {{x, 0, kHalf_m * (2 * k + 1)}, {}}));
    return last + 1 - cubes;
  }
  // A light ball that no gravity pulls, on its way down.
  BodyId add_feather(const Vec3d& at, double speed_m_per_s) {
    auto ball = physics::make_dynamic_body(0, Shape::sphere(0.01), 0.001, 0.5, {at, {}});
    ball.gravity_scale = 0;
    ball.motion.velocity.linear = {0, 0, -speed_m_per_s};
    return add(ball);
  }
};

// A heap in an open box, as pile700 but smaller.
Builder heap() {
  Builder builder;
  PileSpec spec;
  spec.count = 96;
  spec.layers = 4;
  spec.friction = 0.5;
  for (auto body : make_pile(spec)) builder.add(body);
  return builder;
}

}  // namespace

TEST_CASE("A stack that rests falls asleep as one, not before its time, and is then no part of the world") {
  Builder builder;
  const BodyId first = builder.add_stack(0, 5);
  Bench bench(builder.scene);
  bench.run(kSlowSteps - 1);
  CHECK(bench.world.statistics().asleep == 0);
  CHECK(bench.run_until_asleep(5) < 30);
  const auto& s = bench.world.statistics();
  CHECK((s.awake == 1 && s.bodies == 6 && s.fell_asleep == 5 && s.woke_up == 0));
  CHECK(bench.world.world().bodies().size() == 1);
  CHECK(bench.world.is_asleep(first));
  CHECK_FALSE(bench.world.is_asleep(0));
  const auto before = bench.motion(first + 4);
  CHECK(before.velocity == Twistd{});
  bench.run(300);
  CHECK((s.pairs == 0 && s.contacts == 0 && s.asleep == 5));
  CHECK(bench.motion(first + 4).pose == before.pose);
}

TEST_CASE("The effect changes no bit until a body falls asleep, and does nothing if it is not declared") {
  Builder builder = heap();
  Bench with(builder.scene);
  builder.scene.effects.sleeping = false;
  Bench without(builder.scene);
  std::uint32_t steps = 0;
  for (; with.world.statistics().fell_asleep == 0 && steps < 500; ++steps) {
    REQUIRE(with.world.state_hash() == without.world.state_hash());
    with.step();
    without.step();
  }
  CHECK(steps >= kSlowSteps);
  CHECK(steps < 500);
  without.run(100);
  CHECK(without.world.statistics().fell_asleep == 0);
}

TEST_CASE("What an awake body comes near wakes up with its whole island, and no other") {
  Builder builder;
  const BodyId one = builder.add_stack(0, 4), other = builder.add_stack(1, 4);
  const BodyId ball = builder.add_feather({0, 0, 1.2}, 0.5);  // meets the stack of 0.4 m after 1.6 s
  Bench bench(builder.scene);
  bench.run_until_asleep(8);
  while (bench.world.is_asleep(one) && bench.world.statistics().steps < 300) bench.step();
  // Bounds grow by what the ball moves in a step, and by half a millimetre at least on either side.
  const double gap_m = bench.motion(ball).pose.position.z - 0.01 - 0.4;
  CHECK(gap_m < 0.5 * 0.01 + 2e-3);
  CHECK(gap_m > -1e-4);
  for (BodyId k = 0; k < 4; ++k) {
    CHECK_FALSE(bench.world.is_asleep(one + k));
    CHECK(bench.world.is_asleep(other + k));
  }
  CHECK(bench.world.statistics().woke_up == 4);
}

TEST_CASE("A heap that a feather wakes does not jolt: speeds, energy and overlaps stay") {
  Builder builder = heap();
  builder.add_feather({0.01, 0.01, 0.36}, 0.05);  // 3 s above the heap of 0.2 m
  Bench awake(builder.scene), bench(builder.scene);
  // The last step before it falls asleep.
  while (awake.world.statistics().fell_asleep == 0) {
    awake.step();
    if (awake.world.statistics().fell_asleep == 0) bench.step();
  }
  const double overlap_m = bench.deepest_m(), speed = bench.fastest();
  CHECK(overlap_m > 1e-6);
  CHECK(speed < 0.01);
  bench.run_until_asleep(96);
  CHECK(bench.world.statistics().stopped_energy_J < 96 * 0.5 * 0.075 * 0.01 * 0.01);
  const double energy_J = bench.energy_J();
  while (bench.world.statistics().woke_up == 0 && bench.world.statistics().steps < 1000) bench.step();
  REQUIRE(bench.world.statistics().woke_up == 96);
  double fastest = bench.fastest(), deepest = bench.deepest_m(), highest_J = bench.energy_J();
  CHECK(deepest == Approx(overlap_m).epsilon(0.1));
  for (int i = 0; i < 200; ++i) {
    bench.step();
    fastest = std::max(fastest, bench.fastest());
    highest_J = std::max(highest_J, bench.energy_J());
    if (bench.world.statistics().asleep == 0) deepest = std::max(deepest, bench.deepest_m());
  }
  CAPTURE(fastest, deepest, overlap_m, highest_J - energy_J);
  CHECK(fastest < 0.01);
  CHECK(deepest < 1.1 * overlap_m);
  CHECK(highest_J - energy_J < 0.075 * kGravity * 1e-6);  // one cube, lifted by a micrometre
}

TEST_CASE("A stack that wakes carries its weight in the very first step") {
  Builder builder;
  const BodyId first = builder.add_stack(0, 6);
  const BodyId ball = builder.add_feather({0, 0, 0.9}, 0.2);  // 1.3 s above the stack
  Bench bench(builder.scene);
  bench.run_until_asleep(6);
  const auto before = bench.motion(first + 5);
  while (bench.world.is_asleep(first)) bench.step();
  REQUIRE(bench.motion(ball).pose.position.z > 0.6);
  double force_N = 0;
  for (const auto& contact : bench.world.world().contacts())
    if (contact.b_fixed)
      for (std::uint32_t i = 0; i < contact.count; ++i) force_N += contact.points[i].total_normal_impulse / 0.01;
  CHECK(force_N == Approx(6 * kMass_kg * kGravity).epsilon(1e-3));
  // Without warm starts it would have fallen for a sub-step at least: 9.8 mm/s x 1 ms. Aside it sways on, where sleep
  // had stopped it.
  CHECK(std::abs(bench.motion(first + 5).pose.position.z - before.pose.position.z) < 1e-6);
  CHECK(std::abs(bench.motion(first + 5).velocity.linear.z) < 1e-4);
  CHECK(norm(bench.motion(first + 5).velocity.linear) < 0.005);
}

TEST_CASE("What is in reach of the proxy is awake before it is chosen, and stays so") {
  Builder builder;
  const BodyId first = builder.add_stack(0, 3);
  Bench bench(builder.scene);
  bench.run_until_asleep(3);
  bench.impose_proxy({0, 0, 0.33});
  bench.step();
  CHECK(bench.world.statistics().asleep == 0);
  const std::span<const BodyId> members = bench.snapshot->members.span();
  CHECK(std::find(members.begin(), members.end(), first + 2) != members.end());
  bench.run(3 * kSlowSteps);
  CHECK(bench.world.statistics().asleep == 0);
}

TEST_CASE("Whatever hangs together with a member never sleeps") {
  Builder builder;
  const BodyId first = builder.add_stack(0, 5);
  builder.add_stack(2, 5);
  builder.scene.bodies[0].motion.pose.position = {0, 0, 0.52};
  builder.scene.bodies[0].gravity_scale = 1;
  GlobalOptions options = tactus::test::capped_border();
  options.extraction.cap = 2;
  options.reach.max_speed_m_per_s = 0.01;
  options.reach.max_angular_speed_rad_per_s = 0;
  Bench bench(builder.scene, options);
  bench.run_until_asleep(5);
  bench.run(200);
  CHECK_FALSE(bench.world.is_asleep(first));
  CHECK(bench.world.statistics().asleep == 5);
  CHECK(bench.snapshot->component == 6);
}

TEST_CASE("An impulse handed back to a sleeping body wakes it and is not lost") {
  Builder builder;
  const BodyId first = builder.add_stack(0, 1);
  GlobalOptions options;
  options.border_mode = physics::BorderMode::kReplay;
  Bench bench(builder.scene, options);
  bench.run_until_asleep(1);
  haptics::BorderReturn entry;
  entry.member = 0;
  entry.outside = first;
  entry.point = bench.motion(first).pose.position;
  entry.tangent_impulse = {-0.4, 0, 0};
  REQUIRE(bench.report->border.try_push(entry));
  bench.step();
  CHECK_FALSE(bench.world.is_asleep(first));
  // Friction takes mu g t of it.
  CHECK(bench.motion(first).velocity.linear.x == Approx(0.4 / kMass_kg - 0.5 * kGravity * 0.01).epsilon(0.01));
}

TEST_CASE("With from_start, what does not move sleeps from the start but for what is near the proxy") {
  Builder builder;
  const BodyId near = builder.add_stack(0, 2), far = builder.add_stack(3, 2), moving = builder.add_stack(5, 2);
  builder.scene.bodies[0].motion.pose.position = {0, 0, 0.23};
  builder.scene.bodies[moving].motion.velocity.linear = {0.1, 0, 0};
  builder.scene.sleeping.from_start = true;
  Bench bench(builder.scene);
  CHECK(bench.world.statistics().asleep == 2);
  CHECK(bench.world.is_asleep(far));
  CHECK(bench.world.is_asleep(far + 1));
  CHECK_FALSE(bench.world.is_asleep(near));
  CHECK_FALSE(bench.world.is_asleep(moving + 1));
  bench.run(20);
  CHECK(bench.world.is_asleep(far));
}

TEST_CASE("The prediction before the first step leaves sleepers and states as they were") {
  Builder builder;
  const BodyId first = builder.add_stack(0, 3);
  builder.add_feather({0, 0, 0.33}, 1.0);  // would wake them in the second step
  builder.scene.sleeping.from_start = true;
  GlobalWorld world(builder.scene, tactus::test::capped_border());
  REQUIRE(world.is_asleep(first));
  const std::uint64_t hash = world.state_hash();
  auto snapshot = std::make_unique<WorldSnapshot>();
  world.first_snapshot(*snapshot);
  CHECK(world.state_hash() == hash);
  CHECK(world.is_asleep(first));
  auto report = std::make_unique<SubWorldReport>();
  for (int i = 0; i < 3; ++i) world.step(*report, *snapshot);
  CHECK_FALSE(world.is_asleep(first));
}

TEST_CASE("Falling asleep and waking up give the same bits twice") {
  Builder builder = heap();
  builder.add_stack(2, 4);
  builder.add_feather({2, 0, 1.6}, 0.6);
  builder.add_feather({0.01, 0.01, 0.5}, 0.1);
  Bench one(builder.scene), two(builder.scene);
  for (int i = 0; i < 500; ++i) {
    one.step();
    two.step();
    REQUIRE(one.world.state_hash() == two.world.state_hash());
  }
  CHECK(one.world.statistics().woke_up >= 100);
  CHECK(one.world.statistics().fell_asleep >= 200);
}

TEST_CASE("Potential energy goes on when bodies fall asleep") {
  Builder builder;
  builder.add_stack(0, 3);
  Bench bench(builder.scene);
  const double expected_J = kMass_kg * kGravity * kHalf_m * (1 + 3 + 5);
  CHECK(bench.world.potential_energy_J() == Approx(expected_J).epsilon(1e-12));
  bench.run_until_asleep(3);
  CHECK(bench.world.potential_energy_J() == Approx(expected_J).epsilon(1e-3));
  CHECK(bench.world.kinetic_energy_J() == 0);
}

TEST_CASE("A world full of sleepers does the work of those that are awake") {
  const auto work_of = [](unsigned stacks) {
    Builder builder;
    builder.add_stack(0, 3);
    builder.scene.bodies[0].motion.pose.position = {0, 0, 0.33};
    for (unsigned i = 0; i < stacks; ++i) builder.add_stack(1 + 0.2 * i, 4);
    builder.scene.sleeping.from_start = true;
    Bench bench(builder.scene);
    bench.run(5);
    const auto& s = bench.world.statistics();
    CHECK(s.asleep == 4 * stacks);
    return std::array{s.awake, s.pairs, s.contacts, s.points};
  };
  CHECK(work_of(300) == work_of(1));
}
