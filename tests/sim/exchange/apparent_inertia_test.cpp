#include "sim/exchange/apparent_inertia.h"

#include <catch2/catch.hpp>

#include "tests/support/body_index.h"
#include "tests/support/physics_bench.h"

namespace {

using namespace tactus;
using namespace tactus::sim;
using tactus::test::operator""_slot;
using physics::SlotIndex;
using test::PhysicsBench;

constexpr double kHalf = 0.05, kMass = 0.2;
constexpr double kRigid = 1e5;  // a2 of contacts that give way to nothing

PhysicsBench make_bench() {
  PhysicsBench bench(physics::Capacities{64, 2, 256, 256, 0});
  bench.settings.dt = 0.01;
  bench.settings.sub_steps = 10;
  return bench;
}

OutsideAnswer found(const physics::World& world, SlotIndex slot, std::vector<std::uint8_t> members,
                    double added_inertia = kRigid, double step_s = 0.01) {
  ApparentInertia admittance(64, 256, 4);
  members.resize(64, 0);
  admittance.index(world, added_inertia, step_s);
  return admittance.find(slot, members);
}
physics::Admittance answer_of(const PhysicsBench& bench, SlotIndex slot, std::vector<std::uint8_t> members) {
  return found(bench.world, slot, std::move(members)).admittance;
}

// A row of cubes along x without gravity, the first pushed so that all press on each other.
PhysicsBench pushed_row(std::uint32_t count, double friction) {
  PhysicsBench bench = make_bench();
  bench.settings.gravity = {};
  for (std::uint32_t k = 0; k < count; ++k)
    bench.add_box(k, {kHalf, kHalf, kHalf}, kMass, friction, {{2 * kHalf * k, 0, 0}, {}});
  for (int step = 0; step < 20; ++step) {
    bench.world.apply_wrench(0_slot, {{2, 0, 0}, {}});
    bench.step();
  }
  return bench;
}

}  // namespace

TEST_CASE("A body that nothing touches answers with its own mass and inertia") {
  PhysicsBench bench = make_bench();
  bench.add_box(0, {0.02, 0.03, 0.04}, kMass, 0.5, {{1, 2, 3}, quat_from_rotation_vector(Vec3d{0.3, -0.2, 0.5})});
  bench.step();
  const auto w = answer_of(bench, 0_slot, {});
  const auto& body = bench.body(0);
  const Vec3d force{1, -2, 0.5}, torque{0.1, 0.4, -0.3};
  const Twistd turn = w * Wrenchd{force, torque};
  CHECK(norm(turn.linear - force * (1 / kMass)) < 1e-12);
  const Vec3d local = rotate_inverse(body.motion.pose.rotation, torque);
  const Vec3d wanted = rotate(body.motion.pose.rotation,
                              Vec3d{local.x / body.inertia.x, local.y / body.inertia.y, local.z / body.inertia.z});
  CHECK(norm(turn.angular - wanted) < 1e-9 * norm(wanted));
}

TEST_CASE("A cube that stands on the ground answers to no push, as far as its friction holds") {
  PhysicsBench bench = make_bench();
  bench.add_ground(9, 0.5);
  bench.add_stack(0, 3, kHalf, kMass, 0.5);
  bench.run(50);
  const auto w = answer_of(bench, 2_slot, {});  // on two others
  for (const Vec3d& push : {Vec3d{0, 0, -1}, Vec3d{1, 0, 0}, Vec3d{0, 1, 0}})
    CHECK(norm((w * Wrenchd{push, {}}).linear) < 1e-3 / kMass);
  CHECK(norm((w * Wrenchd{{}, {1, 1, 1}}).angular) < 1e-2 / bench.body(2).inertia.x);
}

TEST_CASE("On slippery ground it gives way sideways, and not downwards") {
  PhysicsBench bench = make_bench();
  bench.add_ground(9, 0);
  bench.add_stack(0, 1, kHalf, kMass, 0);
  bench.run(50);
  const auto w = answer_of(bench, 0_slot, {});
  CHECK((w * Wrenchd{{1, 0, 0}, {}}).linear.x == Approx(1 / kMass).epsilon(1e-3));
  CHECK(std::abs((w * Wrenchd{{0, 0, 1}, {}}).linear.z) < 1e-3 / kMass);
}

TEST_CASE("The first outside body of a row answers with the mass of the whole row behind it") {
  const auto count = GENERATE(2u, 5u, 17u);
  const double friction = GENERATE(0.0, 0.5);
  const PhysicsBench bench = pushed_row(count, friction);
  const auto w = answer_of(bench, 1_slot, {1});
  CHECK((w * Wrenchd{{1, 0, 0}, {}}).linear.x == Approx(1 / (kMass * (count - 1))).epsilon(1e-3));
  if (friction == 0) CHECK((w * Wrenchd{{0, 1, 0}, {}}).linear.y >= (1 - 1e-3) / (kMass * (count - 1)));
}

TEST_CASE("A row longer than is followed counts as far as it is followed") {
  const PhysicsBench bench = pushed_row(45, 0);
  const auto w = answer_of(bench, 1_slot, {1});
  const double counted = (w * Wrenchd{{1, 0, 0}, {}}).linear.x * kMass;
  CHECK(counted == Approx(1.0 / ApparentInertia::kMaxBodies).epsilon(0.01));
}

TEST_CASE("An answer never gains energy: work of any wrench on its own answer is not negative") {
  PhysicsBench bench = make_bench();
  bench.add_ground(9, 0.4);
  test::Random random(7);
  for (BodyId k = 0; k < 12; ++k)
    bench.add_box(k, {kHalf, kHalf, kHalf}, kMass, 0.4,
                  {{random(-0.08, 0.08), random(-0.08, 0.08), 0.06 + 0.12 * k}, {}});
  bench.run(60);
  for (std::uint32_t slot = 0; slot < 12; ++slot) {
    const auto w = answer_of(bench, SlotIndex{slot}, {1, 1});
    for (int i = 0; i < 20; ++i) {
      const Wrenchd p{{random(-1, 1), random(-1, 1), random(-1, 1)},
                      {random(-0.1, 0.1), random(-0.1, 0.1), random(-0.1, 0.1)}};
      const Twistd v = w * p;
      CHECK(dot(p.force, v.linear) + dot(p.torque, v.angular) >= 0);
      CHECK(is_finite(v));
    }
  }
}

TEST_CASE("A contact gives way as its spring and damper do over the cycle") {
  PhysicsBench bench = make_bench();
  bench.add_ground(9, 0.5);
  bench.add_stack(0, 1, kHalf, kMass, 0.5);
  bench.run(50);
  // Four points, each G = m a2 in all directions: against a push through the centre downwards they add up.
  for (const double added : {0.5, 40.0, 3000.0}) {
    const Twistd down = found(bench.world, 0_slot, {}, added).admittance * Wrenchd{{0, 0, -1}, {}};
    CHECK(-down.linear.z * kMass == Approx(1 / (1 + 4 * added)).epsilon(1e-3));
  }
}

TEST_CASE(
    "A body that nothing holds goes on as it moves, and so do bodies that press on each other and move together") {
  PhysicsBench bench = pushed_row(5, 0.5);
  const Twistd moving{{0.3, -0.1, 0.2}, {}};
  for (auto& body : bench.world.bodies()) body.motion.velocity = moving;
  const Twistd goes_on = found(bench.world, 2_slot, {1}).velocity;
  // Not to the last digit: the contacts give way by 1 / kRigid.
  CHECK(norm(goes_on.linear - moving.linear) < 1e-5 * norm(moving.linear));
  CHECK(norm(goes_on.angular) < 1e-4);
  bench.world.bodies()[2].motion.velocity = {{1, 2, 3}, {4, 5, 6}};
  const Twistd alone = found(bench.world, 2_slot, {1, 1, 0, 1}).velocity;  // members hold nothing
  CHECK(norm(alone.linear - Vec3d{1, 2, 3}) < 1e-9);
  CHECK(norm(alone.angular - Vec3d{4, 5, 6}) < 1e-9);
}

TEST_CASE("Bodies that press on each other and move apart go on with their common momentum") {
  PhysicsBench bench = pushed_row(3, 0);
  const double speed[3] = {0, 0.2, -0.1};  // the first is a member
  for (int k = 0; k < 3; ++k) bench.world.bodies()[std::size_t(k)].motion.velocity = {{speed[k], 0, 0}, {}};
  CHECK(found(bench.world, 1_slot, {1}).velocity.linear.x == Approx(0.05).epsilon(1e-3));
}

TEST_CASE("Bodies that met within the step go on as they move, not as in the mean of the step") {
  PhysicsBench bench = make_bench();
  bench.settings.gravity = {};
  for (BodyId k = 0; k < 3; ++k)
    bench.add_box(k, {kHalf, kHalf, kHalf}, kMass, 0, {{(2 * kHalf + 0.004) * k, 0, 0}, {}});
  for (const BodyId moves : {0u, 1u}) bench.body(moves).motion.velocity = {{1, 0, 0}, {}};
  bench.step();  // the second, which has the first behind it, hits the third after 4 of 10 ms
  for (const BodyId met : {1u, 2u}) REQUIRE(bench.body(met).motion.velocity.linear.x == Approx(0.5).epsilon(0.05));
  for (const SlotIndex met : {1_slot, 2_slot})
    CHECK(found(bench.world, met, {1}).velocity.linear.x == Approx(0.5).epsilon(0.02));
}

TEST_CASE("A cube that creeps while it is held goes on creeping, whatever its velocity of the instant") {
  PhysicsBench bench = make_bench();
  bench.add_ground(9, 0.5);
  bench.add_stack(0, 1, kHalf, kMass, 0.5);
  bench.run(50);
  const Vec3d crept{2e-5, 0, -1e-5};
  bench.body(0).motion.pose.position += crept;
  bench.body(0).motion.velocity = {{-0.004, 0.001, 0.002}, {0.01, 0, 0}};
  const Twistd goes_on = found(bench.world, 0_slot, {}).velocity;
  CHECK(norm(goes_on.linear - crept * (1 / bench.settings.dt)) < 1e-3 * 0.002);
  CHECK(norm(goes_on.angular) < 1e-3 * 0.01);
}

TEST_CASE("A cube that trembles on the ground stays, one that slides or is carried goes on") {
  const double friction = GENERATE(0.0, 0.5);
  PhysicsBench bench = make_bench();
  bench.add_ground(9, friction);
  bench.add_stack(0, 1, kHalf, kMass, friction);
  bench.run(50);
  bench.body(0).motion.velocity = {{0.01, 0, -0.02}, {0, 0.1, 0}};
  const Twistd goes_on = found(bench.world, 0_slot, {}).velocity;
  CHECK(std::abs(goes_on.linear.z) < 1e-4 * 0.02);
  CHECK(std::abs(goes_on.angular.y) < 1e-3 * 0.1);
  if (friction == 0)
    CHECK(goes_on.linear.x == Approx(0.01).epsilon(1e-3));
  else
    CHECK(std::abs(goes_on.linear.x) < 1e-4 * 0.01);
}

namespace {

// A step's world with effects, without gravity.
struct EffectBench {
  physics::World world;

  explicit EffectBench(const physics::EffectSetups& setups)
      : world(physics::Capacities{64, 2, 256, 256, 0}, physics::ShapeLists{}, setups) {}
  void add_cube(BodyId id, const Vec3d& at) {
    REQUIRE(
        world.insert(physics::make_dynamic_body(id, physics::Shape::box({kHalf, kHalf, kHalf}), kMass, 0.5, {at, {}})));
  }
  physics::Admittance answer_of(SlotIndex slot) {
    physics::StepSettings settings;
    settings.gravity = {};
    world.begin_step(settings);
    find_pairs_brute_force(world.bounds(), world.dynamic_pairs());
    (void)world.finish_step(settings);
    return found(world, slot, {}).admittance;
  }
};

physics::EffectSetups setups_of(const std::vector<physics::Joint>& joints) {
  physics::EffectSetups setups;
  std::get<physics::Joints::Setup>(setups) = {joints};
  return setups;
}

}  // namespace

TEST_CASE("A door answers about its hinge alone, with its inertia there, and not where its motor holds it") {
  const bool held = GENERATE(false, true);
  physics::Joint hinge;
  const double lever_arm = 0.3;
  hinge.kind = physics::JointKind::kHinge;
  hinge.b = 0;
  hinge.a_from_joint.position = {0, 0, 1};
  hinge.b_from_joint.position = {-lever_arm, 0, 0};
  hinge.driven = held;
  hinge.motor_effort = 10;
  const std::vector joints{hinge};
  EffectBench bench(setups_of(joints));
  bench.add_cube(0, {lever_arm, 0, 1});
  const auto w = bench.answer_of(0_slot);
  const double inertia = bench.world.bodies()[0].inertia.z + kMass * lever_arm * lever_arm;
  const Twistd swing = w * Wrenchd{{0, 1, 0}, {}};
  CHECK(swing.linear.y == Approx(held ? 0.0 : lever_arm * lever_arm / inertia).epsilon(1e-3).margin(1e-2));
  CHECK(swing.angular.z == Approx(held ? 0.0 : lever_arm / inertia).epsilon(1e-3).margin(1e-2));
  for (const Vec3d& push : {Vec3d{1, 0, 0}, Vec3d{0, 0, 1}}) CHECK(norm((w * Wrenchd{push, {}}).linear) < 1e-3 / kMass);
}

TEST_CASE("Bodies that a joint holds together answer as far as it holds") {
  physics::Joint joint;
  joint.kind = GENERATE(physics::JointKind::kFixed, physics::JointKind::kSlider, physics::JointKind::kDistance);
  const bool rod = joint.kind == physics::JointKind::kDistance;
  joint.a = 0;
  joint.b = 1;
  joint.limited = rod;
  joint.low = joint.high = rod ? 0.5 : 0;
  if (!rod) joint.b_from_joint.position = {-0.5, 0, 0};
  const std::vector joints{joint};
  EffectBench bench(setups_of(joints));
  bench.add_cube(0, {0, 0, 0});
  bench.add_cube(1, {0.5, 0, 0});
  const auto w = bench.answer_of(0_slot);
  // Along the line between them; along the slider's axis, z, each goes by itself.
  CHECK((w * Wrenchd{{1, 0, 0}, {}}).linear.x == Approx(1 / (2 * kMass)).epsilon(1e-3));
  if (joint.kind == physics::JointKind::kSlider || rod)
    CHECK((w * Wrenchd{{0, 0, 1}, {}}).linear.z == Approx(1 / kMass).epsilon(1e-3));
}

TEST_CASE("A kinematic body answers to nothing, and is a wall to what presses on it") {
  const std::vector<physics::KinematicScript> scripts{{1, 0, 0, false}};
  physics::EffectSetups setups;
  std::get<physics::ScriptedMotion::Setup>(setups) = {scripts, {}};
  EffectBench bench(setups);
  bench.add_cube(0, {0, 0, 0});
  bench.add_cube(1, {2 * kHalf, 0, 0});
  CHECK(norm((bench.answer_of(1_slot) * Wrenchd{{1, 2, 3}, {1, 2, 3}}).linear) == 0);
  bench.world.bodies()[0].motion.velocity.linear = {0.2, 0, 0};
  CHECK(std::abs((bench.answer_of(0_slot) * Wrenchd{{1, 0, 0}, {}}).linear.x) < 1e-3 / kMass);
  bench.world.bodies()[1].motion.velocity.linear = {-0.3, 0, 0};  // and takes it along
  const double pushed_out = 0.01;  // m/s: it ran into the kinematic one, and goes on coming out
  CHECK(found(bench.world, 0_slot, {}, kRigid, 1e-3).velocity.linear.x == Approx(-0.3).margin(pushed_out));
}
