#include <catch2/catch.hpp>

#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::PhysicsBench;

namespace {

constexpr double kMass = 0.5, kHalf = 0.05;

// A cube at the origin without gravity whose lower face an outside body touches, pushing up (+z) with `rate` newtons.
// It is made hard to turn: pressed on one point it would tip over, as mechanics says.
BorderContact& add_border(PhysicsBench& bench, BorderMode mode, double rate, double friction = 0) {
  bench.settings.gravity = {};
  bench.add_box(3, {kHalf, kHalf, kHalf}, kMass, 0.5, {});
  bench.body(3).inertia = {1e6, 1e6, 1e6};
  BorderContact contact;
  contact.member = 3;
  contact.outside = 9;
  contact.normal = {0, 0, 1};
  contact.member_anchor = {0, 0, -kHalf};
  contact.line_point = {0, 0, -kHalf};
  contact.impulse_rate = rate;
  contact.friction = friction;
  bench.world.border_rule.mode = mode;
  REQUIRE(bench.world.add_border_contact(contact));
  return bench.world.border_contacts()[0];
}

PhysicsBench make_bench() {
  Capacities capacities;
  capacities.border_contacts = 4;
  return PhysicsBench(capacities);
}

// Keeps a pull of `force` newtons on the cube at the height of its lower face, so that it does not turn.
void pull(PhysicsBench& bench, const Vec3d& force) {
  bench.world.apply_wrench(bench.slot(3), {force, cross(Vec3d{0, 0, -kHalf}, force)});
}

}  // namespace

TEST_CASE("A capped border holds a load below its cap, exactly and at rest, as deep as a contact's softness says") {
  auto bench = make_bench();
  auto& border = add_border(bench, BorderMode::kCapped, 10);
  for (int k = 0; k < 200; ++k) {
    pull(bench, {0, 0, -9});
    bench.step();
    REQUIRE(border.step_normal_impulse == Approx(9 * bench.settings.dt).epsilon(1e-9));
  }
  CHECK(norm(bench.velocity(3).linear) < 1e-12);
  const double omega = 2 * tactus::test::kPi * bench.settings.contact_hertz;
  CHECK(bench.position(3).z == Approx(-bench.settings.slop - 9 / (kMass * omega * omega)).epsilon(0.01));
  CHECK(border.total_normal_impulse == Approx(200 * 9 * bench.settings.dt).epsilon(1e-9));
}

TEST_CASE("The cap is the pair's: one of its points may carry more than its share, and the torque with it") {
  auto bench = make_bench();
  bench.settings.gravity = {};
  bench.add_box(3, {kHalf, kHalf, kHalf}, kMass, 0.5, {});
  for (int i = 0; i < 2; ++i) {
    BorderContact contact;
    contact.member = 3;
    contact.outside = 9;
    contact.feature = static_cast<std::uint32_t>(i);
    contact.normal = {0, 0, 1};
    contact.member_anchor = {i == 0 ? -kHalf : kHalf, 0, -kHalf};
    contact.line_point = contact.member_anchor;
    contact.impulse_rate = 5;  // each: 10 N together
    REQUIRE(bench.world.add_border_contact(contact));
  }
  bench.world.border_rule.mode = BorderMode::kCapped;
  // Nine newtons down, a quarter of the way in: 6.75 N and 2.25 N. A cap on each point would let the cube tip.
  for (int k = 0; k < 300; ++k) {
    bench.world.apply_wrench(bench.slot(3), {{0, 0, -9}, {0, -9 * 0.5 * kHalf, 0}});
    bench.step();
  }
  const auto& border = bench.world.border_contacts();
  CHECK(border[0].step_normal_impulse == Approx(6.75 * bench.settings.dt).epsilon(1e-4));
  CHECK(border[1].step_normal_impulse == Approx(2.25 * bench.settings.dt).epsilon(1e-3));
  CHECK(norm(bench.velocity(3).angular) < 1e-6);
}

TEST_CASE("A capped border lets an open gap close and stops the body there") {
  auto bench = make_bench();
  auto& border = add_border(bench, BorderMode::kCapped, 1000);
  bench.world.border_contacts()[0].gap = 0.002;
  for (int k = 0; k < 300; ++k) {
    pull(bench, {0, 0, -9});
    bench.step();
  }
  const double omega = 2 * tactus::test::kPi * bench.settings.contact_hertz;
  CHECK(bench.position(3).z == Approx(-0.002 - bench.settings.slop - 9 / (kMass * omega * omega)).epsilon(0.01));
  CHECK(border.step_normal_impulse == Approx(9 * bench.settings.dt).epsilon(1e-6));
}

TEST_CASE("A capped border gives way beyond its cap with exactly the force that is left") {
  auto bench = make_bench();
  auto& border = add_border(bench, BorderMode::kCapped, 10);
  for (int k = 0; k < 100; ++k) {
    pull(bench, {0, 0, -12});
    bench.step();
    REQUIRE(border.step_normal_impulse == Approx(10 * bench.settings.dt).epsilon(1e-9));
  }
  CHECK(bench.velocity(3).linear.z == Approx(-2 / kMass * 0.1).epsilon(1e-9));
}

TEST_CASE("A capped border never pulls and never pushes what already moves away") {
  auto bench = make_bench();
  auto& border = add_border(bench, BorderMode::kCapped, 10);
  bench.velocity(3).linear = {0, 0, 0.1};
  bench.run(10);
  CHECK(border.step_normal_impulse == 0);
  CHECK(bench.velocity(3).linear == Vec3d{0, 0, 0.1});
}

TEST_CASE("A capped border takes a body along at the speed of its neighbour") {
  auto bench = make_bench();
  auto& border = add_border(bench, BorderMode::kCapped, 10);
  border.outside_velocity = {0, 0, 0.05};
  bench.run(1);
  // 10 N on half a kilogram for a millisecond: 20 mm/s, the cap.
  CHECK(bench.velocity(3).linear.z == Approx(0.02).epsilon(1e-9));
  bench.run(20);
  CHECK(bench.velocity(3).linear.z == Approx(0.05).epsilon(1e-9));
  CHECK(border.line_point.z == Approx(-kHalf + 0.05 * 0.021).epsilon(1e-9));  // moves with the neighbour
}

TEST_CASE("A replayed border gives exactly its impulse, whatever the body does") {
  auto bench = make_bench();
  auto& border = add_border(bench, BorderMode::kReplay, 10);
  border.outside_velocity = {1, 1, 1};
  bench.velocity(3).linear = {0.3, 0, 0.2};
  bench.run(50);
  CHECK(bench.velocity(3).linear.z == Approx(0.2 + 10 * 0.05 / kMass).epsilon(1e-12));
  CHECK(bench.velocity(3).linear.x == 0.3);
  CHECK(border.total_normal_impulse == Approx(10 * 0.05).epsilon(1e-12));
  CHECK(norm(border.line_point - Vec3d{0, 0, -kHalf}) == 0);
}

TEST_CASE("A replayed border gives its impulse also when every sweep is cut") {
  auto bench = make_bench();
  add_border(bench, BorderMode::kReplay, 10);
  bench.cut = {[](void*, std::uint32_t) noexcept { return true; }, nullptr};
  bench.run(50);
  CHECK(bench.velocity(3).linear.z == Approx(10 * 0.05 / kMass).epsilon(1e-12));
}

TEST_CASE("A frozen border stands still and holds any load") {
  auto bench = make_bench();
  auto& border = add_border(bench, BorderMode::kFrozen, 0);
  border.outside_velocity = {0, 0, 5};  // ignored
  for (int k = 0; k < 100; ++k) {
    pull(bench, {0, 0, -1000});
    bench.step();
    REQUIRE(std::abs(bench.velocity(3).linear.z) < 1e-9);
    REQUIRE(border.step_normal_impulse == Approx(1000 * bench.settings.dt).epsilon(1e-9));
  }
}

TEST_CASE("A friction point holds at 0.99 mu i and is freed at 1.01 mu i") {
  const double friction = 0.4, press = 10;
  for (const BorderMode mode : {BorderMode::kCapped, BorderMode::kReplay, BorderMode::kFrozen})
    for (const double part : {0.99, 1.01}) {
      auto bench = make_bench();
      auto& border = add_border(bench, mode, mode == BorderMode::kFrozen ? 0 : press + 5, friction);
      // Capped and frozen push back only what presses on them; a replayed impulse is there anyway, held from above.
      const double i = mode == BorderMode::kReplay ? press + 5 : press;
      const double side = part * friction * i;
      int freed_at = -1;
      // Pressed first, pulled then: while the press builds up there is no mu i to hold with.
      for (int k = 0; k < 300; ++k) {
        pull(bench, {0, 0, -i});
        bench.step();
      }
      for (int k = 0; k < 100; ++k) {
        pull(bench, {0.6 * side, 0.8 * side, -i});
        bench.step();
        if (border.friction_free && freed_at < 0) freed_at = k;
      }
      INFO("mode " << static_cast<int>(mode) << " part " << part);
      if (part < 1) {
        CHECK(freed_at == -1);
        CHECK(norm(bench.velocity(3).linear) < 1e-6);
        // The line is as soft as a contact: off it by F / (m omega^2).
        const double omega = 2 * tactus::test::kPi * bench.settings.contact_hertz;
        const Vec3d off = bench.position(3) - Vec3d{0, 0, bench.position(3).z};
        CHECK(norm(off) == Approx(side / (kMass * omega * omega)).epsilon(0.01));
        CHECK(border.step_tangent_impulse.x == Approx(-0.6 * side * bench.settings.dt).epsilon(1e-6));
        CHECK(border.step_tangent_impulse.y == Approx(-0.8 * side * bench.settings.dt).epsilon(1e-6));
      } else {
        CHECK(freed_at == 0);
        CHECK(norm(border.step_tangent_impulse) == 0);  // freed: nothing until it is refreshed
        // Free of it the whole pull accelerates, from the second step on.
        CHECK(bench.velocity(3).linear.x == Approx(0.6 * side / kMass * 0.1).epsilon(0.011));
      }
    }
}

TEST_CASE("A freed friction point works again once it is refreshed") {
  auto bench = make_bench();
  auto& border = add_border(bench, BorderMode::kReplay, 10, 0.5);
  border.friction_free = true;
  pull(bench, {1, 0, -10});
  bench.step();
  CHECK(bench.velocity(3).linear.x == Approx(1e-3 / kMass).epsilon(1e-9));
  border.friction_free = false;
  border.line_point = bench.position(3) + Vec3d{0, 0, -kHalf};
  bench.velocity(3) = {};
  for (int k = 0; k < 50; ++k) {
    pull(bench, {1, 0, -10});
    bench.step();
  }
  CHECK(norm(bench.velocity(3).linear) < 1e-9);
}

TEST_CASE("A friction point draws the body's point back to its line") {
  auto bench = make_bench();
  auto& border = add_border(bench, BorderMode::kReplay, 10, 0.5);
  border.line_point.x += 1e-4;
  for (int k = 0; k < 3000; ++k) {
    pull(bench, {0, 0, -10});
    bench.step();
  }
  CHECK_FALSE(border.friction_free);
  const Posed& pose = bench.body(3).motion.pose;
  CHECK((pose * Vec3d{0, 0, -kHalf}).x == Approx(1e-4).epsilon(0.01));
}

TEST_CASE("In capped mode the friction point's line moves with its neighbour and takes the body along") {
  auto bench = make_bench();
  auto& border = add_border(bench, BorderMode::kCapped, 50, 0.5);
  border.outside_velocity = {0.02, 0, 0};
  bench.velocity(3).linear = {0.02, 0, 0};
  for (int k = 0; k < 200; ++k) {
    pull(bench, {0, 0, -20});
    bench.step();
  }
  CHECK_FALSE(border.friction_free);
  CHECK(bench.position(3).x == Approx(0.004).epsilon(1e-3));
  CHECK(border.line_point.x == Approx(0.004).epsilon(1e-9));
}

TEST_CASE("Without the friction effect a friction point does nothing") {
  auto bench = make_bench();
  bench.settings.friction = false;
  auto& border = add_border(bench, BorderMode::kReplay, 10, 0.5);
  pull(bench, {1, 0, -10});
  bench.step();
  CHECK(bench.velocity(3).linear.x == Approx(1e-3 / kMass).epsilon(1e-9));
  CHECK(border.total_tangent_impulse == Vec3d{});
}

TEST_CASE("The work of the border is the kinetic energy that the body gains") {
  for (const BorderMode mode : {BorderMode::kCapped, BorderMode::kReplay, BorderMode::kFrozen}) {
    auto bench = make_bench();
    bench.settings.gyroscopic = false;
    auto& border = add_border(bench, mode, 10, 0.5);
    bench.body(3).inertia = inertia_of(bench.body(3).shape, kMass);
    border.member_anchor = {0.03, 0.01, -kHalf};
    border.line_point = {0.03, 0.01, -kHalf};
    border.outside_velocity = {0, 0, 0.4};
    bench.velocity(3).linear = {0.001, 0, -0.1};
    for (int k = 0; k < 5; ++k) {
      const double before = bench.world.kinetic_energy(), worked = border.work;
      bench.step();
      const double gained = bench.world.kinetic_energy() - before;
      // A cube's inertia is the same about every axis, so within a step the anchor is all that turns.
      CHECK(border.work - worked == Approx(gained).epsilon(1e-9).margin(1e-12));
    }
    CHECK(std::abs(border.work) > 1e-6);
  }
}

TEST_CASE("A border contact of a body that is not here, or frozen, exerts nothing") {
  auto bench = make_bench();
  auto& border = add_border(bench, BorderMode::kReplay, 10, 0.5);
  border.member = 77;
  bench.step();
  CHECK(bench.velocity(3) == Twistd{});
  CHECK(border.step_normal_impulse == 0);
  border.member = 3;
  bench.world.set_frozen(bench.slot(3), true);
  bench.step();
  CHECK(bench.velocity(3) == Twistd{});
  CHECK(border.step_normal_impulse == 0);
  bench.world.set_frozen(bench.slot(3), false);
  bench.step();
  CHECK(bench.velocity(3).linear.z > 0);
}

TEST_CASE("Border contacts beyond the capacity are refused, counted and named") {
  auto bench = make_bench();
  add_border(bench, BorderMode::kCapped, 1);
  const BorderContact more = bench.world.border_contacts()[0];
  for (int k = 0; k < 3; ++k) REQUIRE(bench.world.add_border_contact(more));
  CHECK_FALSE(bench.world.add_border_contact(more));
  CHECK_FALSE(bench.world.add_border_contact(more));
  bench.step();
  CHECK(bench.report.capacity_bits == kBorderContactsFull);
  CHECK(bench.report.dropped == 2);
  bench.step();
  CHECK(bench.report.capacity_bits == 0);
}
