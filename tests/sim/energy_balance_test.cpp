// The energy balance of a world: an unexplained gain is found, and losses by friction do not hide it.
#include "sim/energy_balance.h"

#include <catch2/catch.hpp>

#include "rt/physics/collision/pair_finder.h"
#include "sim/loader/scene_load.h"

using namespace tactus;
using namespace tactus::sim;

TEST_CASE("a fall, a push of the hand and a loss are explained") {
  EnergyBalance balance;
  balance.add(0, 10, 0, 0);
  balance.add(4, 6, 0, 0);    // falls
  balance.add(5, 6, 0, 1);    // pushed by 1 J
  balance.add(0, 6, 0.5, 1);  // lost; half a joule is in contacts,
  balance.add(0.4, 6, 0.1, 1);
  CHECK(balance.unexplained_J == 0);  // and comes back
  CHECK(balance.most_kinetic_J == 5);
  CHECK(balance.work_in_J == 1);
  CHECK(balance.in_play_J() == 5);
}

TEST_CASE("energy from nowhere is seen, also after more than that was lost") {
  EnergyBalance balance;
  balance.add(5, 0, 0, 0);
  balance.add(1, 0, 0, 0);
  balance.add(3, 0, 0, 0);
  CHECK(balance.unexplained_J == 2);
  balance.add(0, 0, 0, 0);
  balance.add(1, 0, 0, 0);
  CHECK(balance.unexplained_J == 2);  // the most
}

TEST_CASE("what a deep overlap could give is no motion, and what the hand takes out is none that went in") {
  EnergyBalance balance;
  balance.add(1, 0, 0, 0);
  balance.add(1, 0, 50, 0);
  CHECK(balance.unexplained_J == 0);
  balance.add(0.5, 0, 0, -0.5);
  CHECK(balance.unexplained_J == 0);
  CHECK(balance.work_in_J == 0);
}

TEST_CASE("a scene that is reset has its energy again") {
  EnergyBalance balance;
  balance.complete = true;
  balance.add(0, 10, 0, 0);
  balance.add(0, 2, 0, 0);
  balance.reset();
  CHECK(balance.due());
  CHECK_FALSE(balance.due());
  balance.add(0, 10, 0, 0);
  CHECK(balance.unexplained_J == 0);
}

TEST_CASE("a pressed contact's spring is m w^2 e^2 / 2 of what it overlaps beyond the slop, where its body is now") {
  physics::World world({.bodies = 2, .fixed_bodies = 1, .pairs = 8, .contacts = 8});
  physics::StepSettings settings;
  settings.gravity = {};
  REQUIRE(world.insert(physics::make_fixed_body(1, physics::Shape::plane(), 0, {})));
  const double radius = 0.02, mass = 0.5, deep = 1e-3;
  REQUIRE(world.insert(
      physics::make_dynamic_body(0, physics::Shape::sphere(radius), mass, 0, {{0, 0, radius - deep}, {}})));
  world.begin_step(settings);
  (void)physics::find_pairs_brute_force(world.bounds(), world.dynamic_pairs());
  (void)world.finish_step(settings);
  const double omega = 2 * 3.14159265358979 * settings.contact_hertz;
  const double left = radius - world.bodies()[0].motion.pose.position.z - settings.slop;
  REQUIRE(left > 0.5 * deep);
  CHECK(springs_J(world, settings.contact_hertz, settings.slop) == Approx(0.5 * mass * omega * omega * left * left));
}

TEST_CASE("a scene in which more than gravity and the hand does work has no complete balance") {
  const std::string scene = R"(
effects = ["gravity", "friction"EFFECT]
[simulation]
ratio = 10
members = 4
[proxy]
shape = "sphere"
radius_m = 0.01
mass_kg = 0.2
friction = 0.5
RESTITUTIONposition_m = [0, 0, 0.3]
)";
  const auto with = [&](std::string text, const std::string& effect, const std::string& line) {
    text.replace(text.find("EFFECT"), 6, effect);
    text.replace(text.find("RESTITUTION"), 11, line);
    auto parsed = parse_scene(text, "test");
    INFO(parsed.message());
    REQUIRE(parsed.ok());
    return energy_balance_is_complete(parsed.value());
  };
  CHECK(with(scene, "", ""));
  CHECK_FALSE(with(scene, ", \"restitution\"", "restitution = 0.5\n"));
}
