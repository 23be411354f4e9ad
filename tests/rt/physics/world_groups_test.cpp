#include <catch2/catch.hpp>

#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::PhysicsBench;

namespace {

// Three stacks of three on the ground; body 10 s + k is the k-th of stack s.
void add_stacks(PhysicsBench& bench) {
  bench.add_ground(1, 0.5);
  for (BodyId stack = 1; stack <= 3; ++stack)
    for (BodyId k = 0; k < 3; ++k)
      bench.add_box(10 * stack + k, {0.05, 0.05, 0.05}, 0.5, 0.5, {{0.5 * stack, 0, 0.05 + 0.1 * k}, {}});
}

bool slots_match(const World& world) {
  for (const auto& contact : world.contacts()) {
    const BodyId a = world.bodies()[contact.slot_a].id;
    const BodyId b = contact.b_fixed ? world.fixed_bodies()[contact.slot_b].id : world.bodies()[contact.slot_b].id;
    if (PairKey::of(a, b, contact.b_fixed) != contact.key) return false;
  }
  return true;
}

std::vector<BodyId> ids(const World& world) {
  std::vector<BodyId> result;
  for (const auto& body : world.bodies()) result.push_back(body.id);
  return result;
}

}  // namespace

TEST_CASE("Many bodies that leave at once leave the others, their contacts, wrenches and the spring as they were") {
  PhysicsBench one, other;
  for (auto* bench : {&one, &other}) {
    add_stacks(*bench);
    bench->run(50);
    auto& spring = bench->world.device_spring();
    spring.enabled = true;
    spring.slot = bench->slot(32);
    spring.stiffness_N_per_m = 100;
    spring.damping_Ns_per_m = 1;
    spring.target = bench->body(32).motion.pose;
    bench->world.set_frozen(bench->slot(31), true);
    bench->world.apply_wrench(bench->slot(30), {{1, 0, 0}, {}});
  }
  std::vector<std::uint8_t> leaving(9, 0);
  for (const BodyId id : {20u, 21u, 22u, 11u}) leaving[number_of(one.slot(id))] = 1;
  one.world.remove(leaving);
  for (const BodyId id : {20u, 21u, 22u, 11u}) REQUIRE(other.world.remove(id));
  CHECK(ids(one.world) == std::vector<BodyId>{10, 12, 30, 31, 32});
  CHECK(slots_match(one.world));
  CHECK(one.world.contacts().size() == other.world.contacts().size());
  CHECK(one.world.device_spring().slot == SlotIndex{4});
  for (int i = 0; i < 20; ++i) {
    one.step();
    other.step();
    REQUIRE(one.world.state_hash() == other.world.state_hash());
  }
}

TEST_CASE("Many bodies that come at once, between the others, are as if they had come one by one") {
  PhysicsBench one, other;
  std::vector<Body> coming;
  for (auto* bench : {&one, &other}) {
    add_stacks(*bench);
    bench->run(50);
    coming.clear();
    for (const BodyId id : {11u, 20u, 21u, 22u, 32u}) {
      coming.push_back(bench->body(id));
      REQUIRE(bench->world.remove(id));
    }
    bench->run(3);
  }
  REQUIRE(one.world.insert(coming));
  for (const auto& body : coming) REQUIRE(other.world.insert(body));
  CHECK(ids(one.world) == std::vector<BodyId>{10, 11, 12, 20, 21, 22, 30, 31, 32});
  CHECK(slots_match(one.world));
  for (int i = 0; i < 20; ++i) {
    one.step();
    other.step();
    REQUIRE(one.world.state_hash() == other.world.state_hash());
  }
}

TEST_CASE("Many bodies beyond the capacity: none is added, and the report says so") {
  PhysicsBench bench({10, 4, 64, 64, 0});
  add_stacks(bench);
  std::vector<Body> coming;
  for (BodyId id = 40; id < 42; ++id)
    coming.push_back(make_dynamic_body(id, Shape::sphere(0.05), 1, 0.5, {{3.0 + id, 0, 1}, {}}));
  CHECK_FALSE(bench.world.insert(coming));
  CHECK(bench.world.bodies().size() == 9);
  bench.step();
  CHECK(bench.report.capacity_bits == kBodiesFull);
}
