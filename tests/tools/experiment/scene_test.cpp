#include "tools/experiment/scene.h"

#include <catch2/catch.hpp>

#include <cmath>

#include "tools/experiment/engine.h"

using namespace tactus;
using namespace tactus::experiment;

TEST_CASE("A pile has as many cubes as asked for, apart from each other and inside its walls") {
  for (const std::string name : {"pile64", "pile64-stirred", "pile1000"}) {
    const auto scene = make_scene(name, false);
    REQUIRE(scene);
    CHECK(scene->cubes.size() == (name == "pile1000" ? 1000 : 64));
    REQUIRE(scene->walls.size() == 5);
    const double inside = scene->walls[2].half_extents_m.x;
    for (std::size_t i = 0; i < scene->cubes.size(); ++i) {
      const Cube& a = scene->cubes[i];
      CHECK(a.mass_kg == Approx(1.0));
      const double reach = 0.5 * std::sqrt(3.0) * a.edge_m;
      CHECK(std::max(std::abs(a.position.x), std::abs(a.position.y)) + 0.5 * a.edge_m < inside);
      CHECK(a.position.z > reach);
      for (std::size_t j = 0; j < i; ++j) REQUIRE(norm(a.position - scene->cubes[j].position) > a.edge_m);
    }
  }
}

TEST_CASE("The sizes of the mixed pile span 1 to 20 and the mass follows the volume") {
  const auto scene = make_scene("mixed10000", true);
  REQUIRE(scene);
  REQUIRE(scene->cubes.size() == 10000);
  double least = 1, most = 0;
  for (const Cube& cube : scene->cubes) {
    least = std::min(least, cube.edge_m), most = std::max(most, cube.edge_m);
    REQUIRE(cube.mass_kg == Approx(1000 * std::pow(cube.edge_m, 3)));
  }
  CHECK(least == Approx(0.02).epsilon(0.01));
  CHECK(most == Approx(0.4).epsilon(0.01));
  CHECK_FALSE(make_scene("pile63", true));
}

TEST_CASE("The rod's velocity is the change of its place") {
  const auto scene = make_scene("pile64-stirred", true);
  REQUIRE(scene);
  REQUIRE(scene->paddle);
  const double h = 1e-6;
  const Vec3d change = scene->paddle->position_at(0.7 + h) - scene->paddle->position_at(0.7 - h);
  CHECK(norm((0.5 / h) * change - scene->paddle->velocity_at(0.7)) < 1e-8);
}

TEST_CASE("Every engine starts from the same scene") {
  const auto scene = make_scene("pile64", true);
  REQUIRE(scene);
  for (const EngineKind& kind : engine_kinds()) {
    if (!kind.available) continue;
    const auto engine = kind.make(*scene, {.tuned = kind.tuned});
    REQUIRE(engine);
    const auto cubes = engine->cubes();
    REQUIRE(cubes.size() == scene->cubes.size());
    for (std::size_t i = 0; i < cubes.size(); ++i) {
      INFO(kind.name << " " << i);
      REQUIRE(norm(cubes[i].position - scene->cubes[i].position) < 1e-6);
      REQUIRE(norm(cubes[i].velocity) == 0);
    }
    // One step of free fall: g dt by every integrator, with tactus' sub-steps too.
    engine->step();
    CHECK(engine->cubes()[60].velocity.z == Approx(-9.81 * scene->step_s).epsilon(1e-3));
  }
}
