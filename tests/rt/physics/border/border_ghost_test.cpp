#include <catch2/catch.hpp>

#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::PhysicsBench;

namespace {

constexpr double kMass = 0.5, kHalf = 0.05;

Admittance free_mass(double mass) { return {SymMat3d::identity(1 / mass), {}, {}}; }

PhysicsBench border_bench() {
  Capacities capacities;
  capacities.border_contacts = 4;
  return PhysicsBench(capacities);
}

// Adds the ghost of outside body 9 and its contact with member 3.
void add_ghost(PhysicsBench& bench, BorderGhost ghost, BorderContact contact) {
  ghost.outside = contact.outside = 9;
  REQUIRE(bench.world.border_ghosts().try_push(ghost));
  contact.member = 3;
  contact.ghost = 0;
  contact.outside_inverse_mass = 1 / kMass;
  bench.world.border_rule.mode = BorderMode::kGhost;
  REQUIRE(bench.world.add_border_contact(contact));
}

// A cube at the origin without gravity, hard to turn, whose face towards -x touches the ghost of an outside body:
// normal +x. Nothing holds the ghost but its admittance.
struct GhostBench {
  PhysicsBench bench{border_bench()};

  explicit GhostBench(const Admittance& admittance, double friction = 0) {
    bench.settings.gravity = {};
    bench.add_box(3, {kHalf, kHalf, kHalf}, kMass, 0.5, {});
    bench.body(3).inertia = {1e6, 1e6, 1e6};
    BorderGhost ghost;
    ghost.centre = {-2 * kHalf, 0, 0};
    ghost.admittance = admittance;
    BorderContact contact;
    contact.normal = {1, 0, 0};
    contact.member_anchor = contact.line_point = {-kHalf, 0, 0};
    contact.friction = friction;
    add_ghost(bench, ghost, contact);
  }
  BorderGhost& ghost() { return bench.world.border_ghosts()[0]; }
  BorderContact& contact() { return bench.world.border_contacts()[0]; }
  Vec3d& velocity() { return bench.velocity(3).linear; }
  void pull(const Vec3d& force) { bench.world.apply_wrench(bench.slot(3), {force, {}}); }
};

}  // namespace

TEST_CASE("A member that hits a ghost shares its momentum with it, exactly, and they go on together") {
  const double mass = GENERATE(0.05, 0.5, 40.0);
  GhostBench b(free_mass(mass));
  b.velocity() = {-0.3, 0, 0};
  b.ghost().velocity.linear = {0.1, 0, 0};
  const double before = kMass * -0.3 + mass * 0.1;
  for (int k = 0; k < 50; ++k) {
    b.bench.step();
    REQUIRE(kMass * b.velocity().x + mass * b.ghost().velocity.linear.x == Approx(before).epsilon(1e-12));
  }
  CHECK(b.velocity().x == Approx(before / (kMass + mass)).epsilon(1e-6));
  CHECK(b.ghost().velocity.linear.x == Approx(before / (kMass + mass)).epsilon(1e-6));
  CHECK(b.ghost().total_impulse.force.x == Approx(-b.contact().total_normal_impulse).epsilon(1e-12));
}

TEST_CASE("Momentum is shared also when every sweep is cut") {
  GhostBench b(free_mass(2));
  b.velocity() = {-0.3, 0, 0};
  b.bench.run(3);
  b.velocity() = {0.1, 0, 0};  // what was stored pushes too much now: it is scaled
  const double before = kMass * 0.1 + 2 * b.ghost().velocity.linear.x;
  b.bench.cut = {[](void*, std::uint32_t) noexcept { return true; }, nullptr};
  b.bench.run(5);
  CHECK(kMass * b.velocity().x + 2 * b.ghost().velocity.linear.x == Approx(before).epsilon(1e-12));
}

TEST_CASE("A load sinks as deep into a ghost as into the outside body, whatever moves with that") {
  const double admittance = GENERATE(0.0, 0.1, 2.0, 10.0);
  GhostBench b({SymMat3d::identity(admittance), {}, {}});
  const double load = 9;
  b.ghost().drive.linear = {load * admittance, 0, 0};  // the ground holds the outside body against the load
  for (int k = 0; k < 400; ++k) {
    b.pull({-load, 0, 0});
    b.bench.step();
  }
  const double pair_mass = 1 / (1 / kMass + 1 / kMass);
  CHECK(b.contact().gap == Approx(-b.bench.overlap_under(load, pair_mass)).epsilon(1e-3));
  CHECK(b.contact().step_normal_impulse == Approx(load * b.bench.settings.dt).epsilon(1e-6));
  CHECK(std::abs(b.velocity().x) < 1e-6);
}

// An overlap beyond that which max_push_speed corrects still carries M w^2 times its depth, M: effective mass of the
// pair.
TEST_CASE("A deep overlap carries as much against a ghost as against the outside body, whatever moves with that") {
  const double admittance = GENERATE(0.0, 0.1, 2.0, 10.0);
  constexpr double kGap = -0.5 * kHalf;
  const auto opens_under = [admittance](double share) {
    GhostBench b({SymMat3d::identity(admittance), {}, {}});
    const StepSettings& s = b.bench.settings;
    const double omega = 2 * test::kPi * s.contact_hertz;
    const double load = share * 0.5 * kMass * omega * omega * (-kGap - s.slop);
    b.contact().gap = kGap;
    b.ghost().drive.linear = {load * admittance, 0, 0};
    const auto steps = [&](int n) {
      while (n-- > 0) {
        b.pull({-load, 0, 0});
        b.bench.step();
      }
      return b.contact().gap;
    };
    const double pressed = steps(40);  // the impulse grows to the load
    return steps(40) - pressed;
  };
  CHECK(opens_under(0.98) > 0);
  CHECK(opens_under(1.02) < 0);
}

TEST_CASE("Work of the border and of the push-out is what a load gains in energy as it sinks, rises or lands") {
  const double gap = GENERATE(0.0, -5e-4, 1e-3), admittance = GENERATE(0.0, 2.0);
  GhostBench b({SymMat3d::identity(admittance), {}, {}});
  b.bench.settings.gravity = {-9.81, 0, 0};
  b.ghost().drive.linear = {kMass * 9.81 * admittance, 0, 0};
  b.contact().gap = gap;
  const auto energy_J = [&] {
    return b.bench.world.kinetic_energy() + b.bench.world.potential_energy(b.bench.settings.gravity);
  };
  double pushed_J = 0;
  for (int k = 0; k < 100; ++k) {
    const double before_J = energy_J(), worked_J = b.contact().work;
    b.bench.step();
    pushed_J += std::abs(b.bench.report.push_out_J);
    REQUIRE(b.contact().work - worked_J + b.bench.report.push_out_J ==
            Approx(energy_J() - before_J).epsilon(1e-9).margin(1e-12));
  }
  CHECK(pushed_J > 1e-6);
}

TEST_CASE("With an empty tank a ghost still carries a load") {
  GhostBench b({});
  const double load = 9;
  for (int k = 0; k < 1000; ++k) {
    b.bench.world.border_rule.available_J = 0;
    b.pull({-load, 0, 0});
    b.bench.step();
  }
  CHECK(std::abs(b.contact().gap) < 1e-8);
  CHECK(b.contact().step_normal_impulse == Approx(load * b.bench.settings.dt).epsilon(1e-6));
}

TEST_CASE("With an empty tank a ghost that slides carries a load, and its friction does not move it") {
  GhostBench b({}, 0.5);
  b.bench.settings.gravity = {-9.81, 0, 0};
  for (int k = 0; k < 200; ++k) {
    b.bench.world.border_rule.available_J = 0;
    b.ghost().velocity.linear = {0, 0.5, 0};
    b.bench.step();
    REQUIRE(std::abs(b.velocity().x) < 3 * 9.81 * b.bench.h());
  }
  CHECK(std::abs(b.velocity().y) < 1e-3);
  CHECK(std::abs(b.contact().gap) < 1e-4);
}

TEST_CASE("A hand that pushes a member feels the mass of all that moves with the ghost") {
  const double row = 15 * kMass, force = 4;
  GhostBench b(free_mass(row));
  for (int k = 0; k < 100; ++k) {
    b.pull({-force, 0, 0});
    b.bench.step();
  }
  CHECK(b.velocity().x == Approx(-force * 0.1 / (kMass + row)).epsilon(1e-3));
}

TEST_CASE("A ghost pushes what it runs into, and moves on from there") {
  GhostBench b(free_mass(1e9));
  b.ghost().velocity.linear = {0.02, 0, 0};
  b.bench.run(100);
  CHECK(b.velocity().x == Approx(0.02).epsilon(1e-6));
  CHECK(b.ghost().centre.x == Approx(-2 * kHalf + 0.02 * 0.1).epsilon(1e-9));
  CHECK(b.contact().line_point.x == Approx(-kHalf + 0.02 * 0.1).epsilon(1e-3));
}

TEST_CASE("A ghost is never pulled") {
  GhostBench b(free_mass(1));
  b.velocity() = {0.1, 0, 0};
  b.bench.run(20);
  CHECK(b.velocity() == Vec3d{0.1, 0, 0});
  CHECK(b.ghost().velocity.linear == Vec3d{});
}

TEST_CASE("Friction on a ghost sticks below mu times the load, slides above, and takes the ghost along") {
  const double load = 10, mu = 0.4;
  GhostBench b(free_mass(1e9), mu);
  const double part = GENERATE(0.95, 1.25);
  for (int k = 0; k < 300; ++k) {
    b.pull({-load, part * mu * load, 0});
    b.bench.step();
  }
  if (part < 1)
    CHECK(std::abs(b.velocity().y) < 1e-6);
  else
    CHECK(b.velocity().y == Approx((part - 1) * mu * load * 0.3 / kMass).epsilon(0.01));
  CHECK(b.contact().step_tangent_impulse.y ==
        Approx(-std::min(part, 1.0) * mu * load * b.bench.settings.dt).epsilon(1e-3));
  CHECK(b.ghost().total_impulse.force.y == Approx(-b.contact().total_tangent_impulse.y).epsilon(1e-12));
}

TEST_CASE("An impulse off its centre turns a ghost as its admittance says") {
  // A cube of 2 kg, 0.1 m wide, hit on its face 0.03 m above its centre: W has both blocks.
  const double mass = 2, inertia = mass * 0.1 * 0.1 / 6;
  GhostBench b({SymMat3d::identity(1 / mass), SymMat3d::identity(1 / inertia), {}});
  b.contact().member_anchor = b.contact().line_point = {-kHalf, 0, 0.03};
  b.velocity() = {-0.2, 0, 0};
  b.bench.run(1);
  const double p = b.contact().total_normal_impulse;
  REQUIRE(p > 0);
  CHECK(b.ghost().velocity.linear.x == Approx(-p / mass).epsilon(1e-9));
  CHECK(b.ghost().velocity.angular.y == Approx(-p * 0.03 / inertia).epsilon(1e-9));
}

TEST_CASE("A world with ghosts goes on from its saved state to the last bit") {
  GhostBench b(free_mass(0.7), 0.3), c(free_mass(0.1));
  b.ghost().drive.linear = {2, 0.5, 0};
  b.pull({-9, 1, 0});
  b.bench.run(7);
  std::vector<std::byte> bytes(b.bench.world.save_size_bound());
  ByteWriter out(bytes);
  b.bench.world.save(out);
  REQUIRE(out.ok());
  ByteReader in(std::span<const std::byte>(bytes).first(out.size()));
  REQUIRE(c.bench.world.restore(in));
  b.bench.run(20);
  c.bench.run(20);
  CHECK(b.bench.world.state_hash() == c.bench.world.state_hash());
  CHECK(b.ghost().velocity == c.ghost().velocity);
  CHECK(b.ghost().total_impulse == c.ghost().total_impulse);
}

// A ball of radius kHalf that rests on the ghost of a body below it, pressed by gravity.
struct RoundBench {
  PhysicsBench bench{border_bench()};

  RoundBench(const Shape& shape, double friction) {
    bench.add_sphere(3, kHalf, kMass, 0.5, {0, 0, kHalf});
    bench.body(3).shape = shape;
    BorderGhost ghost;
    ghost.centre = {0, 0, -kHalf};
    BorderContact contact;
    contact.normal = {0, 0, 1};
    contact.friction = friction;
    add_ghost(bench, ghost, contact);
  }
  BorderGhost& ghost() { return bench.world.border_ghosts()[0]; }
  BorderContact& contact() { return bench.world.border_contacts()[0]; }
};

TEST_CASE("A ball that rolls over a ghost for a cycle is touched below its centre, and keeps height and speed") {
  const double speed = 3;
  RoundBench b(Shape::sphere(kHalf), 0.5);
  b.contact().member_round = kHalf;
  Twistd& velocity = b.bench.velocity(3);
  velocity = {{speed, 0, 0}, {0, speed / kHalf, 0}};
  for (int k = 0; k < 16; ++k) {
    b.bench.step();
    const Vec3d at = b.bench.position(3);
    CHECK(at.z == Approx(kHalf).margin(3e-5));
    CHECK(velocity.linear.x == Approx(speed).epsilon(1e-3));
    CHECK(velocity.angular.y == Approx(speed / kHalf).epsilon(1e-3));
    CHECK(norm(b.contact().point_on(b.bench.body(3).motion.pose) - (at - Vec3d{0, 0, kHalf})) < 1e-12);
    CHECK(norm(b.contact().line_point - (at - Vec3d{0, 0, kHalf})) < 1e-12);
  }
}

TEST_CASE("A plank on the ghost of a ball that rolls is carried where the ball is, and stays level") {
  const double speed = 1.5;  // of the ball; the plank moves twice as fast
  RoundBench b(Shape::box({0.3, 0.3, kHalf}), 0.5);
  b.contact().member_anchor = {0, 0, -kHalf};
  b.contact().ghost_round = kHalf;
  b.contact().ghost_centre = {};
  b.bench.body(3).inertia = {1e6, 1e6, 1e6};
  b.bench.velocity(3).linear = {2 * speed, 0, 0};
  b.ghost().velocity = {{speed, 0, 0}, {0, speed / kHalf, 0}};
  const Vec3d start = b.ghost().centre;
  for (int k = 0; k < 8; ++k) {
    b.bench.step();
    const Vec3d touched = b.contact().point_on(b.bench.body(3).motion.pose);
    CHECK(touched.x == Approx(b.ghost().centre.x).margin(1e-9));
    CHECK(b.contact().line_point.x == Approx(b.ghost().centre.x).margin(1e-9));
    CHECK(b.bench.position(3).z == Approx(kHalf).margin(3e-5));
    CHECK(b.bench.velocity(3).linear.x == Approx(2 * speed).epsilon(1e-3));
  }
  CHECK(b.ghost().centre.x - start.x == Approx(8e-3 * speed).epsilon(1e-3));
}
