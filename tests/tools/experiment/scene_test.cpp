#include "tools/experiment/scene.h"

#include <catch2/catch.hpp>

#include <array>
#include <cmath>

#include "tools/experiment/quality.h"
#include "tools/experiment/scene_shapes.h"

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
    least = std::min(least, cube.edge_m);
    most = std::max(most, cube.edge_m);
    REQUIRE(cube.mass_kg == Approx(1000 * std::pow(cube.edge_m, 3)));
  }
  CHECK(least == Approx(0.02).epsilon(0.01));
  CHECK(most == Approx(0.4).epsilon(0.01));
  CHECK_FALSE(make_scene("pile63", true));
}

TEST_CASE("Hulls have twenty vertices, mixed shapes span 1 to 4, and masses follow the volumes") {
  const auto hulls = make_scene("hulls1000", true), shapes = make_scene("shapes1000", true);
  REQUIRE(hulls);
  REQUIRE(shapes);
  for (const auto& hull : hulls->hulls) REQUIRE(hull.topology.vertices == 20);
  std::array<int, 5> forms{};
  double least = 1, most = 0;
  for (const Cube& body : shapes->cubes) {
    ++forms[static_cast<std::size_t>(body.form)];
    least = std::min(least, body.edge_m);
    most = std::max(most, body.edge_m);
    REQUIRE(body.mass_kg == Approx(1000 * volume_of(*shapes, body)));
    if (body.form == Form::kHull) REQUIRE(2 * shapes->hulls[body.hull].bounding_radius < 1.2 * body.edge_m);
  }
  CHECK(most / least == Approx(4).epsilon(0.01));
  CHECK(forms[static_cast<std::size_t>(Form::kCube)] == 0);
  for (const Form form : {Form::kSphere, Form::kCapsule, Form::kPlate, Form::kHull})
    CHECK(forms[static_cast<std::size_t>(form)] > 200);
}

// A heap of every form lies on the floor after a second, in every engine, as the judge sees it.
TEST_CASE("Every engine holds bodies of every form") {
  for (const std::vector<Form>& forms : {std::vector{Form::kHull}, {Form::kSphere, Form::kCapsule, Form::kPlate}}) {
    const BoxScene scene = make_pile("forms", {.cubes = 27, .step_s = 2e-3, .forms = forms, .layers = 3});
    for (const EngineKind& kind : engine_kinds()) {
      if (!kind.available) continue;
      INFO(kind.name);
      const auto engine = kind.make(scene, {.tuned = kind.tuned});
      for (int i = 0; i < 500; ++i) engine->step();
      QualitySampler sampler(scene);
      sampler.start(*engine);
      sampler.sample(*engine);
      CHECK(sampler.result().escaped == 0);
      CHECK(sampler.result().overlap_max_share < kMaxOverlapShare);
      for (const CubeState& body : engine->cubes()) CHECK(body.position.z < 0.5);
    }
  }
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
