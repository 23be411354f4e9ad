// Many contacts with ghosts: packed into rows, several side by side.
#include <catch2/catch.hpp>

#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::PhysicsBench;

namespace {

constexpr double kMass = 0.5, kHalf = 0.05;
constexpr BodyId kFirstOutside = 1000;

PhysicsBench bench_for(std::uint32_t bodies, std::uint32_t contacts) {
  Capacities capacities;
  capacities.bodies = bodies;
  capacities.border_contacts = contacts;
  PhysicsBench bench(capacities);
  bench.world.border_rule.mode = BorderMode::kGhost;
  return bench;
}

// Adds the cube `id`, and below it the ghost of a body, with four points at which they touch.
void add_pair(PhysicsBench& bench, std::uint32_t id, double mass, const Vec3d& ghost_velocity) {
  const Vec3d at{0.2 * id, 0, kHalf};
  bench.add_box(id, {kHalf, kHalf, kHalf}, kMass, 0.5, {at, {}});
  BorderGhost ghost;
  ghost.outside = kFirstOutside + id;
  ghost.centre = at - Vec3d{0, 0, 2 * kHalf};
  ghost.velocity.linear = ghost_velocity;
  ghost.admittance = {SymMat3d::identity(1 / mass), SymMat3d::identity(600 / mass), {}};
  const std::uint32_t index = bench.world.border_ghosts().size();
  REQUIRE(bench.world.border_ghosts().try_push(ghost));
  for (std::uint32_t i = 0; i < 4; ++i) {
    BorderContact contact;
    contact.member = id;
    contact.outside = ghost.outside;
    contact.ghost = index;
    contact.feature = i;
    contact.normal = {0, 0, 1};
    contact.member_anchor = {i % 2 == 0 ? kHalf : -kHalf, i < 2 ? kHalf : -kHalf, -kHalf};
    contact.line_point = at + contact.member_anchor;
    contact.friction = 0.3;
    contact.outside_inverse_mass = 1 / mass;
    REQUIRE(bench.world.add_border_contact(contact));
  }
}

double mass_of(std::uint32_t id) { return 0.2 * id; }
Vec3d velocity_of(std::uint32_t id) { return {0.05 * id, -0.02 * id, 0.01 * id}; }

}  // namespace

TEST_CASE("Contacts with ghosts solved side by side have the bits of one alone") {
  constexpr std::uint32_t kPairs = 7;
  PhysicsBench together = bench_for(16, 64);
  for (std::uint32_t id = 1; id <= kPairs; ++id) add_pair(together, id, mass_of(id), velocity_of(id));
  together.run(20);
  for (std::uint32_t id = 1; id <= kPairs; ++id) {
    PhysicsBench alone = bench_for(16, 64);
    add_pair(alone, id, mass_of(id), velocity_of(id));
    alone.run(20);
    CHECK(together.velocity(id) == alone.velocity(id));
    CHECK(together.world.border_ghosts()[id - 1].velocity == alone.world.border_ghosts()[0].velocity);
    CHECK(together.world.border_contacts()[4 * (id - 1)].gap == alone.world.border_contacts()[0].gap);
  }
}

TEST_CASE("A plank on more ghosts than there are colours shares its momentum with all of them, exactly") {
  constexpr std::uint32_t kGhosts = 70;
  const double speed = GENERATE(0.0, 0.2);
  PhysicsBench bench = bench_for(4, kGhosts);
  bench.settings.gravity = {};
  bench.add_box(1, {1, kHalf, kHalf}, kMass, 0.5, {});
  bench.velocity(1).linear = {0, 0, -0.3};
  for (std::uint32_t g = 0; g < kGhosts; ++g) {
    BorderGhost ghost;
    BorderContact contact;
    ghost.outside = contact.outside = kFirstOutside + g;
    ghost.admittance.linear = SymMat3d::identity(10);
    contact.member = 1;
    contact.ghost = g;
    contact.outside_inverse_mass = 10;
    contact.normal = {0, 0, 1};
    contact.member_anchor = contact.line_point = {-0.9 + 1.8 * g / (kGhosts - 1), 0, -kHalf};
    ghost.centre = contact.line_point;
    ghost.velocity.linear = {0, 0, speed};
    REQUIRE(bench.world.border_ghosts().try_push(ghost));
    REQUIRE(bench.world.add_border_contact(contact));
  }
  const double before = kMass * -0.3 + kGhosts * 0.1 * speed;
  bench.run(200);
  double after = kMass * bench.velocity(1).linear.z;
  for (const BorderGhost& ghost : bench.world.border_ghosts()) after += 0.1 * ghost.velocity.linear.z;
  CHECK(after == Approx(before).epsilon(1e-9));
  for (const BorderGhost& ghost : bench.world.border_ghosts()) CHECK(ghost.velocity.linear.z < speed - 1e-3);
}

TEST_CASE(
    "A load sinks as deep whatever share of its initial energy the tank has left, and stays where it is at none") {
  const double left = GENERATE(1.0, 0.5, 0.05, 0.0);
  PhysicsBench bench = bench_for(4, 8);
  add_pair(bench, 1, 1e9, {});
  const auto contacts = bench.world.border_contacts().span();
  for (int k = 0; k < 3000; ++k) {
    bench.world.border_ghosts()[0].velocity = {};
    bench.world.border_rule.available_J = left * traits_of(BorderMode::kGhost).tank_at_start_J;
    bench.step();
  }
  const double depth = left > 0 ? bench.overlap_under(kMass * 9.81, test::cube_face_mass(kMass, kHalf, true)) : 0.0;
  double carried = 0;
  for (const BorderContact& contact : contacts) {
    CHECK(contact.gap == Approx(-depth).epsilon(0.02).margin(1e-6));
    carried += contact.step_normal_impulse;
  }
  CHECK(carried == Approx(kMass * 9.81 * bench.settings.dt).epsilon(1e-4));
}
