// Joints against mechanics: what they hold, what they let go, what they carry and when they break.
#include "rt/physics/effects/joints.h"

#include <catch2/catch.hpp>
#include <optional>
#include <vector>

#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::kGravity;
using tactus::test::kPi;
using tactus::test::PhysicsBench;

namespace {

using Settings = StepSettings;

constexpr double kHalf = 0.05, kMass = 2;

Joint joint_of(JointKind kind, BodyId a, BodyId b, const Posed& a_from_joint, const Posed& b_from_joint) {
  Joint joint;
  joint.kind = kind;
  joint.a = a;
  joint.b = b;
  joint.a_from_joint = a_from_joint;
  joint.b_from_joint = b_from_joint;
  return joint;
}

// A world with joints. They come before the world: it looks into them.
struct JointBench {
  std::vector<Joint> joints;
  std::optional<World> world;
  Settings settings;
  StepReport report;
  std::uint32_t broken{0};
  CutPredicate cut;

  explicit JointBench(std::vector<Joint> given) : joints(std::move(given)) {
    EffectSetups setups;
    std::get<Joints::Setup>(setups) = {joints};
    world.emplace(Capacities{}, ShapeLists{}, setups);
    settings.gravity = {0, 0, -kGravity};
  }
  void add_box(BodyId id, const Vec3d& half, double mass, const Vec3d& at, const Twistd& velocity = {}) {
    auto made = make_dynamic_body(id, Shape::box(half), mass, 0.5, {at, {}});
    made.motion.velocity = velocity;
    REQUIRE(world->insert(made));
  }
  void add_cube(BodyId id, const Vec3d& at, const Twistd& velocity = {}) {
    add_box(id, {kHalf, kHalf, kHalf}, kMass, at, velocity);
  }
  void step() {
    world->begin_step(settings);
    find_pairs_brute_force(world->bounds(), world->dynamic_pairs());
    report = world->finish_step(settings, cut);
    broken += report.broken_joints;
  }
  void run_seconds(double seconds) {
    for (long i = std::lround(seconds / settings.dt); i > 0; --i) step();
  }
  BodyMotion& motion(BodyId id) { return world->find(id)->motion; }
  const Joints& effect() const { return *world->effects().find<Joints>(); }
  const JointState& state(std::size_t joint = 0) const { return effect().states()[joint]; }
};

}  // namespace

TEST_CASE("A fixed joint carries a cantilever: force m g, torque m g L, sunk by the contact's compliance") {
  const double lever_arm = 0.3;
  // To the world; the joint is `lever_arm` beside the cube's centre.
  JointBench bench({joint_of(JointKind::kFixed, kNoBody, 1, {{0, 0, 1}, {}}, {{-lever_arm, 0, 0}, {}})});
  bench.add_cube(1, {lever_arm, 0, 1});
  bench.run_seconds(2);
  CHECK(bench.report.joints == 1);
  CHECK(norm(bench.state().force) == Approx(kMass * kGravity).epsilon(1e-4));
  CHECK(norm(bench.state().torque) == Approx(kMass * kGravity * lever_arm).epsilon(1e-3));
  // Less than the whole weight on the whole lever_arm through the softest direction alone: F / (m w^2) (1 + m L^2 / I).
  const double omega = 2 * kPi * bench.settings.contact_hertz, inertia = kMass * 4 * kHalf * kHalf / 6;
  const double sag = kGravity / (omega * omega) * (1 + 2 * kMass * lever_arm * lever_arm / inertia);
  CHECK(std::abs(bench.motion(1).pose.position.z - 1) < sag);
  CHECK(norm(bench.motion(1).velocity.linear) < 1e-6);
}

TEST_CASE("Under a hanging weight the spring of a joint, and that of a limit, store (m g)^2 / (2 m w^2)") {
  Joint slider = joint_of(JointKind::kSlider, kNoBody, 1, {{0, 0, 1}, {}}, {});  // along z, the weight on its limit
  slider.limited = true;
  slider.high = 1;
  for (const Joint& joint : {joint_of(JointKind::kBall, kNoBody, 1, {{0, 0, 1}, {}}, {}), slider}) {
    JointBench bench({joint});
    bench.add_cube(1, {0, 0, 1});
    const auto springs_J = [&] { return bench.world->joint_springs_J(bench.settings.contact_hertz); };
    CHECK(springs_J() == 0);
    bench.run_seconds(2);
    const double omega = 2 * kPi * bench.settings.contact_hertz;
    CHECK(springs_J() == Approx(kMass * kGravity * kGravity / (2 * omega * omega)).epsilon(1e-3));
  }
}

TEST_CASE("A ball joint makes a pendulum with the period of a physical pendulum") {
  const double length = 0.5, angle = 0.02;
  JointBench bench({joint_of(JointKind::kBall, kNoBody, 1, {{0, 0, 2}, {}}, {{0, 0, length}, {}})});
  const Quatd tilt = quat_from_rotation_vector(Vec3d{0, angle, 0});
  bench.add_cube(1, {});
  bench.motion(1).pose = {Vec3d{0, 0, 2} - rotate(tilt, Vec3d{0, 0, length}), tilt};
  const double inertia = kMass * 4 * kHalf * kHalf / 6 + kMass * length * length;
  const double period = 2 * kPi * std::sqrt(inertia / (kMass * kGravity * length));
  // From the start, at rest, x returns to its start after a whole period: count crossings of zero.
  double last = bench.motion(1).pose.position.x, first_crossing = 0, time = 0, longest = 0;
  int crossings = 0;
  while (crossings < 9) {
    bench.step();
    time += bench.settings.dt;
    const double x = bench.motion(1).pose.position.x;
    if (last * x < 0 && ++crossings == 1) first_crossing = time;
    last = x;
    longest = std::max(longest, std::abs(norm(bench.motion(1).pose.position - Vec3d{0, 0, 2}) - length));
    REQUIRE(time < 20);
  }
  CHECK((time - first_crossing) / 4 == Approx(period).epsilon(2e-3));
  CHECK(longest < 1e-4);
}

TEST_CASE("A hinge turns about its axis alone, and its angle is the rotation of B") {
  JointBench bench({joint_of(JointKind::kHinge, kNoBody, 1, {{}, {}}, {{-0.2, 0, 0}, {}})});
  bench.settings.gravity = {};
  bench.add_cube(1, {0.2, 0, 0}, {{0, 2 * 0.2, 0}, {0, 0, 2}});
  const double energy = bench.world->kinetic_energy();
  bench.run_seconds(1);
  // Free of torque about the axis: 2 rad/s for a second.
  CHECK(bench.state().coordinate == Approx(2.0).epsilon(5e-3));
  CHECK(bench.motion(1).pose.position.x == Approx(0.2 * std::cos(2.0)).margin(2e-3));
  CHECK(bench.motion(1).pose.position.y == Approx(0.2 * std::sin(2.0)).margin(2e-3));
  CHECK(std::abs(bench.motion(1).pose.position.z) < 1e-9);
  CHECK(bench.world->kinetic_energy() <= energy * (1 + 1e-9));
  CHECK(bench.world->kinetic_energy() == Approx(energy).epsilon(5e-3));
  // The centripetal force m w^2 r.
  CHECK(norm(bench.state().force) == Approx(kMass * 4 * 0.2).epsilon(1e-2));
}

TEST_CASE("A hinge stops at its limits, and its motor keeps its speed until the torque is not enough") {
  Joint hinge = joint_of(JointKind::kHinge, kNoBody, 1, {}, {});
  hinge.limited = true;
  hinge.low = -0.5;
  hinge.high = 0.5;
  SECTION("limits") {
    JointBench bench({hinge});
    bench.settings.gravity = {};
    bench.add_cube(1, {}, {{}, {0, 0, 3}});
    double most = 0;
    for (int i = 0; i < 1000; ++i) {
      bench.step();
      most = std::max(most, std::abs(bench.state().coordinate));
    }
    CHECK(most <= 0.5 + 1e-3);
    CHECK(most > 0.499);
    CHECK(norm(bench.motion(1).velocity.angular) < 1e-3);
  }
  SECTION("motor") {
    hinge.limited = false;
    hinge.driven = true;
    hinge.motor_speed = 4;
    hinge.motor_effort = 0.05;
    JointBench bench({hinge});
    bench.settings.gravity = {};
    bench.add_cube(1, {});
    const double inertia = kMass * 4 * kHalf * kHalf / 6;
    bench.run_seconds(0.1);  // torque / inertia x time = 1.5 rad/s
    CHECK(bench.motion(1).velocity.angular.z == Approx(0.05 / inertia * 0.1).epsilon(1e-6));
    bench.run_seconds(1);
    CHECK(bench.motion(1).velocity.angular.z == Approx(4.0).epsilon(1e-9));
  }
}

TEST_CASE("A slider falls along its axis as a free body does, and stops at its limit with the weight on it") {
  Joint slider = joint_of(JointKind::kSlider, kNoBody, 1, {{0, 0, 1}, {}}, {});
  slider.limited = true;
  slider.low = -0.2;
  slider.high = 1;
  JointBench bench({slider});
  bench.add_cube(1, {0, 0, 1}, {{1, 0.5, 0}, {1, 2, 3}});  // what it may not do is taken at once
  bench.run_seconds(0.1);
  const double n = 400, h = bench.settings.dt / bench.settings.sub_steps;
  CHECK(bench.motion(1).pose.position.z == Approx(1 - kGravity * h * h * n * (n + 1) / 2).epsilon(1e-9));
  CHECK(std::abs(bench.motion(1).pose.position.x) < 1e-3);
  CHECK(norm(bench.motion(1).velocity.angular) < 1e-6);
  bench.run_seconds(1);
  CHECK(bench.state().coordinate == Approx(-0.2).margin(2e-5));
  CHECK(norm(bench.state().force) == Approx(kMass * kGravity).epsilon(1e-5));
}

TEST_CASE("A distance joint is a rod where its limits agree and a rope where they do not") {
  Joint rod = joint_of(JointKind::kDistance, kNoBody, 1, {{0, 0, 2}, {}}, {});
  rod.limited = true;
  rod.low = rod.high = 0.5;
  SECTION("rod") {
    JointBench bench({rod});
    bench.add_cube(1, {0.5, 0, 2});
    double worst = 0;
    for (int i = 0; i < 2000; ++i) {
      bench.step();
      worst = std::max(worst, std::abs(bench.state().coordinate - 0.5));
    }
    CHECK(worst < 2e-4);
  }
  SECTION("rope") {
    rod.low = 0;
    JointBench bench({rod});
    bench.add_cube(1, {0, 0, 1.8});
    bench.step();
    CHECK(bench.motion(1).velocity.linear.z == Approx(-kGravity * bench.settings.dt).epsilon(1e-9));  // slack: falls
    bench.run_seconds(1.5);
    CHECK(bench.motion(1).pose.position.z == Approx(1.5).margin(2e-5));
    CHECK(norm(bench.state().force) == Approx(kMass * kGravity).epsilon(1e-5));
  }
}

TEST_CASE("Joints between free bodies keep momentum and angular momentum") {
  JointBench bench({joint_of(JointKind::kBall, 1, 2, {{0.1, 0, 0}, {}}, {{-0.1, 0, 0}, {}}),
                    joint_of(JointKind::kHinge, 2, 3, {{0.1, 0, 0}, {}}, {{-0.1, 0, 0}, {}}),
                    joint_of(JointKind::kFixed, 3, 4, {{0.1, 0, 0}, {}}, {{-0.1, 0, 0}, {}})});
  bench.settings.gravity = {};
  for (BodyId id = 1; id <= 4; ++id)
    bench.add_cube(id, {0.2 * id, 0, 0}, {{0.1 * id, -0.05 * id, 0.2}, {0.3, 0.1 * id, -0.2}});
  const Wrenchd before = bench.world->momentum();
  const double energy = bench.world->kinetic_energy();
  bench.run_seconds(1);
  const Wrenchd after = bench.world->momentum();
  CHECK(norm(after.force - before.force) < 1e-9 * norm(before.force));
  CHECK(norm(after.torque - before.torque) < 2e-3 * norm(before.torque));
  CHECK(bench.world->kinetic_energy() <= energy * (1 + 1e-9));
}

TEST_CASE("A joint breaks above its force, not below, once and for good, and says so") {
  Joint weld = joint_of(JointKind::kFixed, kNoBody, 1, {{0, 0, 1}, {}}, {});
  for (const double strength : {0.99, 1.01}) {
    weld.break_force_N = strength * kMass * kGravity;
    JointBench bench({weld});
    bench.add_cube(1, {0, 0, 1});
    bench.run_seconds(1);
    CHECK(bench.broken == (strength < 1 ? 1 : 0));
    CHECK((bench.state().broken != 0) == (strength < 1));
    CHECK((bench.motion(1).pose.position.z < 0.5) == (strength < 1));
  }
}

TEST_CASE("Joined bodies do not collide unless asked") {
  for (const bool collide : {false, true}) {
    Joint slider = joint_of(JointKind::kSlider, 1, 2, {}, {});
    slider.bodies_collide = collide;
    JointBench bench({slider});
    bench.settings.gravity = {};
    bench.add_cube(1, {});
    bench.add_cube(2, {0, 0, 0.3}, {{0, 0, -1}, {}});
    bool touched = false;
    for (int i = 0; i < 1000; ++i) {
      bench.step();
      touched = touched || !bench.world->contacts().empty();
    }
    CHECK((bench.motion(2).pose.position.z > bench.motion(1).pose.position.z) == collide);
    CHECK(touched == collide);
  }
}

TEST_CASE("A chain of ten with 100 kg at its end hangs, and a cut of every sweep makes no energy") {
  std::vector<Joint> links;
  for (BodyId id = 1; id <= 10; ++id)
    links.push_back(joint_of(JointKind::kBall, id == 1 ? kNoBody : id - 1, id,
                             id == 1 ? Posed{{0, 0, 3}, {}} : Posed{{0, 0, -0.05}, {}}, {{0, 0, 0.05}, {}}));
  JointBench bench(links);
  for (BodyId id = 1; id <= 9; ++id) bench.add_box(id, {0.01, 0.01, 0.05}, 0.1, {0, 0, 3.05 - 0.1 * id});
  bench.add_box(10, {0.05, 0.05, 0.05}, 100, {0, 0, 3.05 - 1.0});
  SECTION("hangs") {
    bench.run_seconds(3);
    CHECK(norm(bench.state(0).force) == Approx((0.9 + 100) * kGravity).epsilon(1e-2));
    // Each joint gives by its load over m w^2, m the effective mass between its links: the compliance of contacts.
    const double omega = 2 * kPi * bench.settings.contact_hertz;
    double stretch = 0;
    for (int k = 0; k < 10; ++k) {
      const double above = k == 0 ? 0 : 1 / 0.1, below = k == 9 ? 1 / 100.0 : 1 / 0.1;
      stretch += (100 + 0.1 * (9 - k)) * kGravity * (above + below) / (omega * omega);
    }
    CHECK(2.05 - bench.motion(10).pose.position.z == Approx(stretch).epsilon(0.02));
  }
  SECTION("cut") {
    struct Cut {
      std::uint32_t at{0};
    } cut;
    bench.cut = {[](void* context, std::uint32_t sweep) noexcept { return sweep >= static_cast<Cut*>(context)->at; },
                 &cut};
    bench.motion(10).velocity.linear = {0.5, 0, 0};
    const auto energy = [&] {
      return bench.world->kinetic_energy() + bench.world->potential_energy(bench.settings.gravity);
    };
    const double before = energy();
    double most = before;
    for (std::uint32_t i = 0; i < 2000; ++i) {
      cut.at = i % 8;
      bench.step();
      most = std::max(most, energy());
    }
    CHECK(most - before < 0.5);  // of 12.5 J kinetic and 2 kJ potential; the joints' springs give back what they took
    CHECK(norm(bench.motion(10).pose.position - Vec3d{0, 0, 3}) < 1.2);
  }
}

TEST_CASE("What joints hold is saved and restored: the same bits follow, broken ones stay so") {
  Joint weld = joint_of(JointKind::kFixed, 1, 2, {{0.05, 0, 0}, {}}, {{-0.05, 0, 0}, {}});
  Joint weak = joint_of(JointKind::kBall, kNoBody, 3, {{1, 0, 0}, {}}, {});
  weak.break_force_N = 1;
  const auto fill = [](JointBench& bench) {
    bench.add_cube(1, {0, 0, 0}, {{0, 1, 0}, {1, 2, 3}});
    bench.add_cube(2, {0.1, 0, 0});
    bench.add_cube(3, {1, 0, 0});
  };
  JointBench one({weld, weak}), other({weld, weak});
  fill(one);
  fill(other);
  one.run_seconds(0.1);
  REQUIRE(one.state(1).broken != 0);
  std::vector<std::byte> bytes(one.world->save_size_bound());
  ByteWriter out(bytes);
  one.world->save(out);
  REQUIRE(out.ok());
  ByteReader in(std::span<const std::byte>(bytes).first(out.size()));
  REQUIRE(other.world->restore(in));
  CHECK(in.remaining() == 0);
  CHECK(other.state(1).broken != 0);
  one.run_seconds(0.1);
  other.run_seconds(0.1);
  CHECK(one.world->state_hash() == other.world->state_hash());
  ByteReader cut(std::span<const std::byte>(bytes).first(out.size() - 1));
  CHECK_FALSE(other.world->restore(cut));
}

TEST_CASE("A joint to a body of another world follows that body's motion") {
  const std::vector<Joint> links{joint_of(JointKind::kBall, 1, 2, {{0.1, 0, 0}, {}}, {{-0.1, 0, 0}, {}})};
  JointBench whole(links), part(links);
  for (JointBench* bench : {&whole, &part}) bench->settings.gravity = {};
  whole.add_cube(1, {}, {{0.5, 0, 0}, {}});
  whole.add_cube(2, {0.2, 0, 0}, {{0.5, 0, 0}, {}});
  part.add_cube(2, {0.2, 0, 0}, {});
  std::vector<std::byte> bytes(4096);
  ByteWriter out(bytes);
  const std::uint8_t inside[] = {0, 1};
  whole.world->effects().export_state(out, std::as_const(*whole.world).bodies(), inside);
  REQUIRE(out.ok());
  ByteReader in(std::span<const std::byte>(bytes).first(out.size()));
  REQUIRE(part.world->effects().import_state(in, {}, false));
  CHECK(in.remaining() == 0);
  part.run_seconds(0.1);
  // The anchor moves on at 0.5 m/s and takes the cube along.
  CHECK(part.motion(2).pose.position.x == Approx(0.25).margin(1e-3));
  CHECK(part.motion(2).velocity.linear.x == Approx(0.5).epsilon(1e-3));
}
