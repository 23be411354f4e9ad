// Joints across the border: one body is here, the other is known by its ghost.
#include <array>
#include <catch2/catch.hpp>
#include <vector>

#include "rt/physics/effects/joints.h"
#include "rt/physics/world.h"
#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::kGravity;

namespace {

constexpr BodyId kA = 0, kB = 1;
constexpr double kMassA = 3, kMassB = 2;
const Vec3d kHalf{0.05, 0.04, 0.03};
const Vec3d kAtB{0.1, 0.02, 0};

Joint joint_of(JointKind kind) {
  Joint joint;
  joint.kind = kind;
  joint.a = kA;
  joint.b = kB;
  joint.a_from_joint.position = 0.5 * kAtB;
  joint.b_from_joint.position = -0.5 * kAtB;
  if (kind == JointKind::kDistance) {
    joint.limited = true;
    joint.a_from_joint = {};
    joint.b_from_joint = {};
    joint.low = joint.high = norm(kAtB);
  }
  return joint;
}

Body body_of(BodyId id) {
  auto body =
      make_dynamic_body(id, Shape::box(kHalf), id == kA ? kMassA : kMassB, 0.5, {id == kA ? Vec3d{} : kAtB, {}});
  if (id == kB) body.motion.velocity = {{0.02, 0.3, -0.1}, {0.5, 0, 1}};
  return body;
}

struct Bench {
  std::vector<Joint> joints;
  World world;
  StepSettings settings;
  StepReport report;
  double border_J{0};

  explicit Bench(JointKind kind) : joints{joint_of(kind)}, world(Capacities{4, 1, 8, 8, 4}, {}, setups()) {
    REQUIRE(world.insert(body_of(kB)));
  }
  EffectSetups setups() const {
    EffectSetups setups;
    std::get<Joints::Setup>(setups) = {joints};
    return setups;
  }
  // What this world, which has both bodies, tells one that has B alone.
  void tell_of_a(Bench& other) {
    std::array<std::byte, 1024> bytes;
    ByteWriter out{std::span<std::byte>(bytes)};
    const std::uint8_t b_alone[] = {0, 1};
    world.effects().export_state(out, world.bodies(), b_alone);
    ByteReader in{std::span<const std::byte>(bytes).first(out.size())};
    REQUIRE(other.world.effects().import_state(in, std::as_const(other.world).bodies(), false));
  }
  void add_ghost() {
    BorderGhost ghost;
    const Vec3d& inertia = body_of(kA).inertia;
    ghost.outside = kA;
    ghost.admittance.linear = SymMat3d::identity(1 / kMassA);
    ghost.admittance.angular = {1 / inertia.x, 1 / inertia.y, 1 / inertia.z, 0, 0, 0};
    world.border_rule.mode = BorderMode::kGhost;
    REQUIRE(world.border_ghosts().try_push(ghost));
  }
  void step(int steps) {
    for (int i = 0; i < steps; ++i) {
      world.begin_step(settings);
      find_pairs_brute_force(world.bounds(), world.dynamic_pairs());
      report = world.finish_step(settings);
      border_J += report.border_joints_J;
    }
  }
  const BodyMotion& motion(BodyId id) const { return world.find(id)->motion; }
};

}  // namespace

TEST_CASE("A joint moves a body against a ghost as it does against the body that the ghost stands for") {
  const auto kind =
      GENERATE(JointKind::kFixed, JointKind::kBall, JointKind::kHinge, JointKind::kSlider, JointKind::kDistance);
  CAPTURE(static_cast<int>(kind));
  Bench both(kind), one(kind);
  REQUIRE(both.world.insert(body_of(kA)));
  both.tell_of_a(one);
  one.add_ghost();
  both.step(10);
  one.step(10);
  const auto &whole = both.motion(kB), &half = one.motion(kB);
  const double pulled = norm(whole.velocity.linear - body_of(kB).motion.velocity.linear);
  REQUIRE(pulled > 0.01);
  CHECK(norm(whole.velocity.linear - half.velocity.linear) < 0.01 * pulled);
  CHECK(norm(whole.pose.position - half.pose.position) < 1e-4 * norm(whole.pose.position - kAtB));
  const auto& ghost = one.world.border_ghosts()[0];
  CHECK(norm(both.motion(kA).velocity.linear - ghost.velocity.linear) < 0.01 * pulled);
  // Summed with sign, but for what the levers turn within a sub-step.
  const double lost_J = kinetic_energy(body_of(kB)) - kinetic_energy(one.world.bodies()[0]);
  CHECK(one.border_J == Approx(-lost_J).epsilon(1e-5));
  // The ghost was given what the body here lost.
  const Vec3d lost = kMassB * (body_of(kB).motion.velocity.linear - half.velocity.linear);
  CHECK(norm(ghost.total_impulse.force - lost) < 1e-12);
  const Twistd by_impulse = ghost.admittance * ghost.total_impulse;
  CHECK(norm(ghost.velocity.linear - by_impulse.linear) < 1e-12);
  CHECK(norm(ghost.velocity.angular - by_impulse.angular) < 1e-9);
}

TEST_CASE("Without a ghost the body of another world goes on as it was, whatever a joint does to it") {
  Bench both(JointKind::kBall), one(JointKind::kBall);
  REQUIRE(both.world.insert(body_of(kA)));
  both.tell_of_a(one);
  both.step(10);
  one.step(10);
  CHECK(norm(both.motion(kB).velocity.linear - one.motion(kB).velocity.linear) > 0.01);
}

TEST_CASE("A ghost that may not give does no work on a body through a joint") {
  Bench both(JointKind::kBall), one(JointKind::kBall);
  REQUIRE(both.world.insert(body_of(kA)));
  both.tell_of_a(one);
  one.add_ghost();
  one.world.border_ghosts()[0].velocity.linear = {0, 2, 0};
  const bool may_give = GENERATE(true, false);
  one.world.border_rule.available_J = may_give ? 1 : 0;
  one.step(10);
  if (may_give)
    CHECK(one.border_J > 0.01);
  else
    CHECK(one.border_J <= 0);
}

// A sub-step that starts with some energy left could give any amount in it.
TEST_CASE("A ghost gives no more work through a joint than is left of the available energy, in any sub-step") {
  const auto kind =
      GENERATE(JointKind::kFixed, JointKind::kBall, JointKind::kHinge, JointKind::kSlider, JointKind::kDistance);
  CAPTURE(static_cast<int>(kind));
  const auto given_of = [kind](double available_J) {
    Bench both(kind), one(kind);
    REQUIRE(both.world.insert(body_of(kA)));
    both.tell_of_a(one);
    one.add_ghost();
    one.world.border_ghosts()[0].velocity = {{1, 2, 0}, {0, 1, 3}};
    for (int i = 0; i < 20; ++i) {
      one.world.border_rule.available_J = available_J - one.border_J;
      one.step(1);
    }
    return one.border_J;
  };
  const double free_J = given_of(1e9);
  REQUIRE(free_J > 0.1);
  for (const double part : {0.001, 0.1, 0.5}) CHECK(given_of(part * free_J) <= 1.001 * part * free_J);
  CHECK(given_of(0.5 * free_J) > 0.1 * free_J);
}

namespace {

// B hangs below A, by a joint halfway between them; A is known by a ghost that all but nothing moves.
struct HangingBench : Bench {
  static constexpr double kBelow = 0.1;

  explicit HangingBench(JointKind kind) : Bench(kind) {
    Joint& joint = joints[0];
    joint.a_from_joint = {{0, 0, -0.5 * kBelow}, {}};
    joint.b_from_joint = {{0, 0, 0.5 * kBelow}, {}};
    if (kind == JointKind::kDistance) {
      joint.a_from_joint = joint.b_from_joint = {};
      joint.low = joint.high = kBelow;
    }
    Bench both(kind);
    REQUIRE(both.world.insert(body_of(kA)));
    both.tell_of_a(*this);
    add_ghost();
    world.border_ghosts()[0].admittance = {SymMat3d::identity(1e-9), SymMat3d::identity(1e-9), {}};
    world.bodies()[0].motion = {{{0, 0, -kBelow}, {}}, {}};
    settings.gravity = {0, 0, -kGravity};
  }
  double sag() const { return -kBelow - motion(kB).pose.position.z; }
};

}  // namespace

TEST_CASE("What hangs on a ghost hangs as low as on its body, whatever moves with that") {
  const auto kind = GENERATE(JointKind::kFixed, JointKind::kBall, JointKind::kSlider, JointKind::kDistance);
  CAPTURE(static_cast<int>(kind));
  HangingBench b(kind);
  if (kind == JointKind::kSlider) {
    b.joints[0].limited = true;
    b.joints[0].low = b.joints[0].high = 0;
  }
  b.step(400);
  // k = m w^2 of the pair's own mass: with the ghost's it would be that of B alone.
  const double omega = 2 * 3.14159265358979323846 * b.settings.contact_hertz;
  CHECK(b.sag() == Approx(kMassB * kGravity * (1 / kMassA + 1 / kMassB) / (omega * omega)).epsilon(0.01));
}

TEST_CASE("With an empty tank a ghost still holds what hangs on it") {
  const auto kind = GENERATE(JointKind::kFixed, JointKind::kBall, JointKind::kDistance);
  CAPTURE(static_cast<int>(kind));
  HangingBench b(kind);
  b.world.border_rule.available_J = 0;
  b.step(1000);
  CHECK(std::abs(b.sag()) < 1e-6);
}
