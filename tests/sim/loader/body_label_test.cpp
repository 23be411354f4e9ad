#include "sim/loader/body_label.h"

#include <catch2/catch.hpp>

#include "sim/loader/scene_load.h"

using namespace tactus;

TEST_CASE("a body is called by its name or number, with the line of the scene that it comes from") {
  const auto scene = sim::parse_scene(R"([proxy]
shape = "sphere"
radius_m = 0.01
mass_kg = 0.1
[[body]]
name = "door"
shape = "sphere"
radius_m = 0.01
mass_kg = 1
[[body]]
shape = "plane"
[[generate]]
kind = "tower"
)",
                                      "x.toml");
  INFO(scene.message());
  REQUIRE(scene.ok());
  CHECK(sim::body_label(scene.value(), 0) == "the proxy (line 1)");
  CHECK(sim::body_label(scene.value(), 1) == "'door' (line 5)");
  CHECK(sim::body_label(scene.value(), 2) == "body 2 (line 10)");
  CHECK(sim::body_label(scene.value(), 3) == "body 3 (of the [[generate]] of line 12)");
  CHECK(sim::body_label(scene.value(), 9999) == "body 9999");
}
