#include "sim/global_world.h"

#include <utility>

#include "tests/sim/global_world_bench.h"
#include "tests/support/bits.h"

namespace {

using namespace tactus;
using namespace tactus::sim;
using haptics::CouplingScheme;
using haptics::SubWorldReport;
using haptics::WorldSnapshot;
using physics::Shape;
using test::same_bits;
using Bench = test::GlobalWorldBench;

constexpr double kSide_m = 0.1, kMass_kg = 0.2, kGravity = 9.81;

// Cubes stacked on a plane, the top one the proxy: as heavy as the others, held by nobody.
Scene stack(unsigned cubes) {
  Scene scene;
  scene.effects = {true, true, true};
  for (unsigned i = 0; i < cubes; ++i)
    scene.bodies.push_back(physics::make_dynamic_body(i, Shape::box({kSide_m / 2, kSide_m / 2, kSide_m / 2}), kMass_kg,
                                                      0.5, {{0, 0, kSide_m * (0.5 + i)}, {}}));
  scene.proxy = cubes - 1;
  scene.bodies.push_back(physics::make_fixed_body(cubes, Shape::plane(), 0.5, {}));
  return scene;
}

// Floating balls far from each other, the first one the proxy.
Scene floating(unsigned balls) {
  Scene scene;
  for (unsigned i = 0; i < balls; ++i)
    scene.bodies.push_back(physics::make_dynamic_body(i, Shape::sphere(0.1), 2.0, 0.5, {{3.0 * i, 0, 0}, {}}));
  scene.proxy = 0;
  return scene;
}

GlobalOptions slow_device() {
  GlobalOptions options = tactus::test::capped_border();
  options.reach.max_speed_m_per_s = 1e-3;
  options.reach.max_angular_speed_rad_per_s = 0;
  options.reach.margin_m = 0;
  return options;
}

std::vector<BodyId> ids(const WorldSnapshot& snapshot) { return {snapshot.members.begin(), snapshot.members.end()}; }

haptics::MemberMotion motion(BodyId id, const Vec3d& where, const Vec3d& velocity) {
  haptics::MemberMotion m;
  m.id = id;
  m.motion.pose = {where, quat_from_rotation_vector(Vec3d{0.1, 0.2, 0.3})};
  m.motion.velocity = {velocity, {1, 2, 3}};
  return m;
}

}  // namespace

TEST_CASE("The first snapshot holds the bodies in touch with the proxy, whole, bit by bit, at cycle 0") {
  Bench bench(stack(4), slow_device());
  CHECK(bench.snapshot->cycle == 0);
  CHECK(bench.snapshot->component == 4);
  CHECK(ids(*bench.snapshot) == std::vector<BodyId>{0, 1, 2, 3});
  REQUIRE(bench.snapshot->joiners.size() == 4);
  for (std::uint32_t i = 0; i < 4; ++i) CHECK(same_bits(bench.snapshot->joiners[i], bench.scene.bodies[i]));
  CHECK(bench.snapshot->border.empty());
  CHECK(bench.snapshot->warm_starts.empty());
  CHECK(bench.world.time_s() == 0);
}

TEST_CASE("Bodies further apart than the tolerance do not touch at the start") {
  Scene scene = stack(4);
  scene.bodies[0].motion.pose.position.z -= 3e-4;  // into the plane, away from its neighbour
  Bench bench(scene, slow_device());
  CHECK(bench.snapshot->component == 3);
}

TEST_CASE("The members' state is imposed bit by bit, leavers included") {
  Bench bench(floating(4), slow_device());
  REQUIRE(bench.report->members.try_push(motion(0, {0.1, 0.2, 0.3}, {1e-3, 2, -1.0 / 3})));
  REQUIRE(bench.report->members.try_push(motion(2, {6.1, 0.2, 0.3}, {0.7, 0, 0})));  // no member any more
  bench.world.impose(0, *bench.report);
  for (const auto& member : bench.report->members) CHECK(same_bits(bench.body(member.id).motion, member.motion));
  CHECK(same_bits(bench.body(1).motion, bench.scene.bodies[1].motion));
}

TEST_CASE("The work of imposing is counted: kinetic and potential energy") {
  Scene scene = floating(1);
  scene.effects.gravity = true;
  scene.bodies[0].motion.pose.position = {0, 0, 0.2};
  scene.bodies[0].motion.velocity.linear = {0, 1, 0};
  Bench bench(scene, slow_device());
  auto member = motion(0, {0, 0, 0.5}, {3, 0, 0});
  member.motion.velocity.angular = {};
  REQUIRE(bench.report->members.try_push(member));
  bench.world.impose(0, *bench.report);
  CHECK(bench.world.statistics().imposed_energy_J == Approx(0.5 * 2 * (9 - 1) + 2 * kGravity * (0.5 - 0.2)));
}

TEST_CASE("A state that is not a number is not imposed") {
  Bench bench(floating(2), slow_device());
  REQUIRE(bench.report->members.try_push(motion(0, {std::nan(""), 0, 0}, {})));
  bench.report->mean_device_wrench.force.x = std::nan("");
  bench.step();
  CHECK(bench.world.statistics().rejected_states == 1);
  CHECK(same_bits(bench.body(0).motion, bench.scene.bodies[0].motion));
}

// Of the couplings that hold the proxy by a wrench: all but the sub-world's and interpolation.
GlobalOptions held_by_wrench() {
  GlobalOptions options = slow_device();
  options.coupling = CouplingScheme::kStatic;
  return options;
}

TEST_CASE("The device's mean wrench holds the proxy over the step, once") {
  Bench bench(floating(2), held_by_wrench());
  bench.report->mean_device_wrench.force = {4, 0, 0};
  bench.step();
  CHECK(bench.body(0).motion.velocity.linear.x == Approx(4 * 0.01 / 2.0));
  bench.report->mean_device_wrench = {};
  bench.step();
  CHECK(bench.body(0).motion.velocity.linear.x == Approx(4 * 0.01 / 2.0));
  CHECK(bench.body(1).motion.velocity.linear == Vec3d{});
}

TEST_CASE("A device's wrench that changes is expected to change on by most of it, and never to turn round") {
  Bench bench(floating(2), held_by_wrench());
  double last = 0;
  const auto given = [&](double force_N) {
    bench.report->mean_device_wrench.force = {force_N, 0, 0};
    bench.step();
    const double now = bench.body(0).motion.velocity.linear.x;
    return (now - std::exchange(last, now)) * 2.0 / 0.01;
  };
  CHECK(given(4) == Approx(4));
  // More than half of the change, so that a ramp is followed; never more than all of it, which would overshoot one.
  const double ahead_N = given(6) - 6;
  CHECK(ahead_N > 0.5 * 2);
  CHECK(ahead_N <= 2);
  CHECK(given(1) == Approx(0).margin(1e-9));  // not 1 - 4
}

TEST_CASE("The global clock and the cycle number go on by one step each") {
  Bench bench(floating(2), slow_device());
  for (int i = 1; i <= 5; ++i) {
    bench.step();
    CHECK(bench.snapshot->cycle == static_cast<std::uint64_t>(i));
    CHECK(bench.snapshot->global_time_s == Approx(0.01 * i));
  }
}

TEST_CASE("At the border of a resting stack the impulses carry what stands above it") {
  GlobalOptions options = slow_device();
  options.extraction.cap = 2;
  // Members: the top two of four. Nothing is imposed, so that the stack rests as the global world has it.
  Bench bench(stack(4), options);
  for (int i = 0; i < 100; ++i) bench.step();
  REQUIRE(ids(*bench.snapshot) == std::vector<BodyId>{2, 3});
  REQUIRE(bench.snapshot->border.size() == 4);
  double force = 0;
  for (const auto& point : bench.snapshot->border) {
    CHECK(point.member == 2);
    CHECK(point.outside == 1);
    CHECK(norm(point.normal - Vec3d{0, 0, 1}) < 1e-4);
    const Vec3d where = bench.body(2).motion.pose * point.member_anchor;
    CHECK(std::abs(where.z - 2 * kSide_m) < 1e-4);
    CHECK(std::abs(where.x) == Approx(kSide_m / 2).margin(1e-4));
    CHECK(std::abs(where.y) == Approx(kSide_m / 2).margin(1e-4));
    CHECK(norm(point.outside_velocity) < 1e-3);
    force += point.impulse_rate_N;
  }
  CHECK(force == Approx(2 * kMass_kg * kGravity).epsilon(0.01));
  CHECK(bench.snapshot->component == 4);
}

TEST_CASE("Static geometry is never a border") {
  GlobalOptions options = slow_device();
  Bench bench(stack(2), options);
  for (int i = 0; i < 20; ++i) bench.step();
  CHECK(ids(*bench.snapshot) == std::vector<BodyId>{0, 1});
  CHECK(bench.snapshot->border.empty());
}

TEST_CASE("A joiner comes whole, bit by bit, with the impulses of its contacts") {
  // The proxy floats above a stack of two and is then put on it: the stack joins.
  Scene scene = stack(3);
  scene.bodies[2].motion.pose.position.z += 0.5;
  scene.bodies[2].gravity_scale = 0;
  Bench bench(scene, slow_device());
  for (int i = 0; i < 50; ++i) bench.step();
  REQUIRE(ids(*bench.snapshot) == std::vector<BodyId>{2});
  // It overlaps by less than the slop: it touches, and nothing pushes.
  auto member = motion(2, bench.body(1).motion.pose.position + Vec3d{0, 0, kSide_m - 5e-6}, {});
  member.motion.pose.rotation = {};
  member.motion.velocity = {};
  REQUIRE(bench.report->members.try_push(member));
  bench.step();
  REQUIRE(ids(*bench.snapshot) == std::vector<BodyId>{0, 1, 2});
  REQUIRE(bench.snapshot->joiners.size() == 2);
  for (std::uint32_t i = 0; i < 2; ++i) CHECK(same_bits(bench.snapshot->joiners[i], bench.body(i)));
  // 0 on the plane carries both, 1 on 0 carries itself, at rest.
  const auto force_of = [&](PairKey key) {
    double force = 0;
    for (const auto& warm : bench.snapshot->warm_starts)
      for (std::uint32_t i = 0; i < warm.count && warm.key == key; ++i) force += warm.normal_force[i];
    return force;
  };
  CHECK(force_of(PairKey::of(0, 3, true)) == Approx(2 * kMass_kg * kGravity).epsilon(0.05));
  CHECK(force_of(PairKey::of(0, 1, false)) == Approx(kMass_kg * kGravity).epsilon(0.05));
  // Those that stay are not sent again.
  bench.report->members.clear();
  bench.step();
  CHECK(bench.snapshot->joiners.empty());
  CHECK(bench.snapshot->warm_starts.empty());
}

TEST_CASE("A snapshot is complete when the cap is full") {
  GlobalOptions options = slow_device();
  options.extraction.cap = 7;
  options.extraction.order = GENERATE(CutOrder::kBestFirst, CutOrder::kBreadthFirst);
  Bench bench(stack(12), options);
  for (int i = 0; i < 30; ++i) {
    bench.step();
    const auto members = ids(*bench.snapshot);
    const auto is_member = [&](BodyId id) { return std::binary_search(members.begin(), members.end(), id); };
    REQUIRE(members.size() == 7);
    REQUIRE(std::is_sorted(members.begin(), members.end()));
    REQUIRE(is_member(bench.scene.proxy));
    for (const auto& joiner : bench.snapshot->joiners) CHECK(is_member(joiner.id));
    for (const auto& point : bench.snapshot->border) CHECK((is_member(point.member) && !is_member(point.outside)));
    for (const auto& warm : bench.snapshot->warm_starts)
      CHECK((is_member(warm.key.low()) || is_member(warm.key.high())));
    CHECK(bench.snapshot->component == 12);
    CHECK(same_bits(bench.snapshot->proxy, bench.body(11).motion));
  }
  CHECK(bench.snapshot->border.size() == 4);
  CHECK(bench.world.statistics().most_members == 7);
}

TEST_CASE("A member budget lowers the cap of the next cycle") {
  Bench bench(stack(10), slow_device());
  CHECK(bench.snapshot->members.size() == 10);
  bench.report->member_budget = 4;
  bench.step();
  CHECK(ids(*bench.snapshot) == std::vector<BodyId>{6, 7, 8, 9});
}

TEST_CASE("Friction of the sub-world reaches the outside body, in replay as it is") {
  GlobalOptions options = slow_device();
  options.border_mode = physics::BorderMode::kReplay;
  Bench bench(floating(3), options);
  haptics::BorderReturn entry;
  entry.member = 0;
  entry.outside = 1;
  entry.point = bench.body(1).motion.pose.position;
  entry.tangent_impulse = {0, 0.3, -0.1};
  REQUIRE(bench.report->border.try_push(entry));
  bench.step();
  CHECK(norm(2.0 * bench.body(1).motion.velocity.linear + entry.tangent_impulse) < 1e-15);
  CHECK(bench.world.statistics().returned_impulse_Ns == Approx(norm(entry.tangent_impulse)));
}

TEST_CASE("Sub-world: the coupling's spring holds the proxy in the step, in sweeps of either precision") {
  GlobalOptions options = slow_device();
  options.gains = {300, 4, 1, 0.01};
  options.precision = GENERATE(physics::SweepPrecision::kFull, physics::SweepPrecision::kSingle);
  Bench bench(floating(2), options);
  const auto start = bench.body(0).motion;
  bench.report->device = {true, {start.pose.position + Vec3d{0, 1e-3, 0}, start.pose.rotation}, {{0, 0.02, 0}, {}}};
  bench.step();
  const double mass = bench.scene.bodies[0].mass;
  const std::uint32_t sub_steps = bench.scene.solver.global_sub_steps(options.reach.ratio);
  const double h = options.reach.ratio * options.reach.tick_period_s / sub_steps, gain = h * (4 + h * 300);
  double x = 0, v = 0;
  for (std::uint32_t j = 0; j < sub_steps; ++j) {
    v = (mass * v + gain * 0.02 - h * 300 * (x - (1e-3 + j * h * 0.02))) / (mass + gain);
    x += h * v;
  }
  const double epsilon = options.precision == physics::SweepPrecision::kFull ? 1e-9 : 1e-6;
  CHECK(bench.body(0).motion.velocity.linear.y == Approx(v).epsilon(epsilon));
  CHECK(bench.body(0).motion.pose.position.y - start.pose.position.y == Approx(x).epsilon(epsilon));
  bench.report->device = {};  // not engaged: it comes to rest
  for (int i = 0; i < 200; ++i) bench.step();
  CHECK(norm(bench.body(0).motion.velocity.linear) < 0.3 * v);
}

namespace {

GlobalOptions ghosts(std::uint32_t members) {
  GlobalOptions options = slow_device();
  options.border_mode = physics::BorderMode::kGhost;
  options.extraction.cap = members;
  return options;
}

}  // namespace

TEST_CASE("With ghosts a snapshot corrects the members of the cycle that ends, by the error of their prediction") {
  Bench bench(stack(3), ghosts(2));  // the proxy on top
  REQUIRE(ids(*bench.snapshot) == std::vector<BodyId>{1, 2});
  CHECK(bench.snapshot->corrections.empty());  // no cycle has ended
  bench.step();
  REQUIRE(bench.snapshot->corrections.size() == 2);
  CHECK(bench.snapshot->corrections[0].id == 1);
  CHECK(bench.snapshot->corrections[1].id == 2);
  const auto moved = motion(2, {5, 5, 5}, {1, 0, 0});
  REQUIRE(bench.report->members.try_push(moved));
  bench.step();
  CHECK(norm(bench.body(2).motion.pose.position - moved.motion.pose.position) < 0.02);
  CHECK(norm(bench.snapshot->corrections[1].displacement_m) < 1e-3);  // it falls in both
}

TEST_CASE("Without ghosts a snapshot has no corrections, and members keep their impulses") {
  Bench bench(stack(3), slow_device());
  bench.run(3);
  CHECK(bench.snapshot->corrections.empty());
  CHECK(bench.snapshot->warm_starts.empty());
}

TEST_CASE("With ghosts a snapshot gives the impulses of all contacts of members with each other and fixed bodies") {
  Bench bench(stack(12), ghosts(7));
  bench.run(10);
  REQUIRE(bench.snapshot->joiners.empty());
  const auto members = ids(*bench.snapshot);
  const auto is_member = [&](BodyId id) { return std::binary_search(members.begin(), members.end(), id); };
  std::vector<PairKey> expected, given;
  for (const auto& contact : bench.world.world().contacts())
    if (is_member(contact.key.low()) && is_member(contact.key.high())) expected.push_back(contact.key);
  for (const auto& warm : bench.snapshot->warm_starts) given.push_back(warm.key);
  CHECK(expected.size() == 6);
  CHECK(given == expected);
}

TEST_CASE("Members that meet no outside body are not corrected and keep their impulses") {
  Bench bench(stack(5), ghosts(5));
  bench.run(10);
  REQUIRE(ids(*bench.snapshot).size() == 5);
  CHECK(bench.snapshot->corrections.empty());
  CHECK(bench.snapshot->warm_starts.empty());
}

TEST_CASE(
    "Interpolation: the proxy alone is a member, the coupling's spring holds it in the step, nothing is imposed") {
  GlobalOptions options = slow_device();
  options.precision = physics::SweepPrecision::kFull;
  options.coupling = CouplingScheme::kInterpolation;
  options.gains = {300, 4, 1, 0.01};
  Bench bench(stack(3), options);
  CHECK(ids(*bench.snapshot) == std::vector<BodyId>{2});
  Bench loose(floating(2), options);
  const auto start = loose.body(0).motion;
  REQUIRE(loose.report->members.try_push(motion(0, {9, 9, 9}, {9, 9, 9})));
  loose.report->mean_device_wrench.force = {100, 0, 0};
  loose.report->device = {true, {start.pose.position + Vec3d{0, 1e-3, 0}, start.pose.rotation}, {{0, 0.02, 0}, {}}};
  loose.step();
  // Implicit Euler of a mass on a spring and damper to a moving target, however many passes the step is taken in.
  const double mass = loose.scene.bodies[0].mass;
  const auto& reach = options.reach;
  const std::uint32_t sub_steps = loose.scene.solver.global_sub_steps(reach.ratio);
  const double h = reach.ratio * reach.tick_period_s / sub_steps, gain = h * (4 + h * 300);
  double x = 0, v = 0;
  for (std::uint32_t j = 0; j < sub_steps; ++j) {
    v = (mass * v + gain * 0.02 - h * 300 * (x - (1e-3 + j * h * 0.02))) / (mass + gain);
    x += h * v;
  }
  CHECK(loose.body(0).motion.velocity.linear.y == Approx(v).epsilon(1e-9));
  CHECK(loose.body(0).motion.pose.position.y - start.pose.position.y == Approx(x).epsilon(1e-9));
  CHECK(std::abs(loose.body(0).motion.pose.position.x - start.pose.position.x) < 1e-15);
  CHECK(same_bits(loose.snapshot->proxy, loose.body(0).motion));
  CHECK(loose.snapshot->joiners.empty());
  // What is no number holds nothing, nor does a device that lets go: the damper brings the proxy to rest.
  for (const bool engaged : {true, false}) {
    loose.report->device = {engaged, {{0, std::nan(""), 0}, {}}, {}};
    const double before = norm(loose.body(0).motion.velocity.linear);
    loose.step();
    CHECK(norm(loose.body(0).motion.velocity.linear) < before);
  }
}

TEST_CASE("Interpolation: a device that moves on is followed, pass by pass, and the spring does not throw the proxy") {
  GlobalOptions options = slow_device();
  options.coupling = CouplingScheme::kInterpolation;
  options.gains = {2000, 100, 1, 0.01};
  Bench bench(floating(1), options);
  const auto start = bench.body(0).motion.pose;
  const Vec3d velocity{0, 10, 0};  // so fast that a step is several passes
  const double step_s = bench.world.step_s();
  for (int i = 0; i < 100; ++i) {
    bench.report->device = {true, {start.position + (i * step_s) * velocity, start.rotation}, {velocity, {}}};
    bench.step();
  }
  CHECK(norm(bench.body(0).motion.pose.position - start.position - (100 * step_s) * velocity) < 1e-6);
  CHECK(norm(bench.body(0).motion.velocity.linear - velocity) < 1e-4);
}

TEST_CASE("Static: only the proxy is imposed, the other members join again in each snapshot, without a border") {
  GlobalOptions options = slow_device();
  options.coupling = CouplingScheme::kStatic;
  options.extraction.cap = 3;
  Bench bench(stack(5), options);
  REQUIRE(ids(*bench.snapshot) == std::vector<BodyId>{2, 3, 4});
  REQUIRE(bench.report->members.try_push(motion(2, {7, 7, 7}, {})));
  auto proxy = motion(4, {0, 0, 4.5 * kSide_m}, {});
  REQUIRE(bench.report->members.try_push(proxy));
  bench.world.impose(0, *bench.report);
  CHECK(same_bits(bench.body(2), bench.scene.bodies[2]));
  CHECK(same_bits(bench.body(4).motion, proxy.motion));
  bench.report->members.clear();
  for (int i = 0; i < 5; ++i) bench.step();
  CHECK(bench.snapshot->border.empty());
  CHECK(bench.snapshot->warm_starts.empty());
  REQUIRE(bench.snapshot->joiners.size() == 2);
  CHECK(same_bits(bench.snapshot->joiners[0], bench.body(2)));
  CHECK(same_bits(bench.snapshot->joiners[1], bench.body(3)));
}

TEST_CASE("All members: every moving body from cycle 0") {
  GlobalOptions options = slow_device();
  options.extraction.all_members = true;
  Bench bench(floating(100), options);
  CHECK(bench.snapshot->members.size() == 100);
  CHECK(bench.snapshot->joiners.size() == 100);
  bench.step();
  CHECK(bench.snapshot->members.size() == 100);
  CHECK(bench.snapshot->joiners.empty());
}

TEST_CASE("Scenes and options that cannot run are refused in one line") {
  const auto message = [](const Scene& scene, const GlobalOptions& options) {
    return check_global_options(scene, options).message();
  };
  GlobalOptions options;
  CHECK(message(floating(3), options).empty());
  options.coupling = CouplingScheme::kDirect;
  CHECK(message(floating(3), options).find("direct") != std::string::npos);
  options.coupling = CouplingScheme::kInterpolation;
  options.more_devices = {{.proxy = 1}};
  CHECK(message(floating(3), options).find("holds one proxy") != std::string::npos);
  options.coupling = CouplingScheme::kSubWorld;
  CHECK(message(floating(3), options).empty());
  options.extraction.all_members = true;
  CHECK(message(floating(3), options).find("several devices") != std::string::npos);
  options = {};
  options.more_devices = {{.proxy = 1}, {.proxy = 2}, {.proxy = 3}, {.proxy = 4}};
  CHECK(message(floating(5), options).find("5 devices") != std::string::npos);
  options.more_devices = {{.proxy = 0}};
  CHECK(message(floating(3), options).find("body 0 is no proxy") != std::string::npos);
  options = {};
  options.extraction.cap = 257;
  CHECK(message(floating(3), options).find("257") != std::string::npos);
  options = {};
  options.reach.ratio = 0;
  CHECK(message(floating(3), options).find("ratio") != std::string::npos);
  options = {};
  options.extraction.all_members = true;
  CHECK(message(floating(257), options).find("257") != std::string::npos);
  CHECK(message(floating(256), options).empty());
  options = {};
  options.border_mode = physics::BorderMode::kReplay;
  options.extraction.cap = 2;
  Scene linked = floating(3);
  CHECK(message(linked, options).empty());
  linked.effect_data.joints.resize(1);
  linked.effect_data.joints[0].a = 1;
  linked.effect_data.joints[0].b = 2;
  CHECK(message(linked, options).find("border replay") != std::string::npos);
  CHECK(message(linked, options).find("ghost, or 3 members") != std::string::npos);
  options.extraction.cap = 3;
  CHECK(message(linked, options).empty());
  Scene scene = stack(2);
  scene.proxy = 2;  // the plane
  CHECK(message(scene, {}).find("proxy") != std::string::npos);
}

TEST_CASE("The same scene and reports give the same bits") {
  GlobalOptions options = slow_device();
  options.extraction.cap = 3;
  Bench one(stack(6), options), two(stack(6), options);
  for (int i = 0; i < 20; ++i) {
    for (Bench* bench : {&one, &two}) {
      bench->report->mean_device_wrench.force = {0.3 * i, 0.1, -1};
      bench->step();
    }
    REQUIRE(one.world.state_hash() == two.world.state_hash());
    REQUIRE(ids(*one.snapshot) == ids(*two.snapshot));
  }
}
