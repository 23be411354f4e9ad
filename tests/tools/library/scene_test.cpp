// A scene through the public API.
#include "tests/tools/library/library_bench.h"

using namespace tactus;
using namespace tactus::test;
using Catch::Matchers::Contains;

TEST_CASE("a scene lists the bodies of its text") {
  Scene scene;
  REQUIRE_FALSE(scene.parse(R"(
title = "Two"
effects = ["gravity", "friction"]
[proxy]
shape = "capsule"
radius_m = 0.01
length_m = 0.03
mass_kg = 0.2
position_m = [0, 0, 0.5]
[[body]]
shape = "plane"
[[body]]
name = "crate"
shape = "box"
size_m = [0.1, 0.2, 0.4]
mass_kg = 3
friction = 0.25
position_m = [1, 2, 3]
)",
                            "two"));
  CHECK(scene.title() == "Two");
  CHECK(scene.name() == "two");
  CHECK_THAT(scene.text(), Contains("crate"));
  REQUIRE(scene.bodies() == 3);
  CHECK(scene.proxy() == 0);
  CHECK(scene.body_name(0) == "proxy");
  CHECK(scene.body_name(1) == "body 1");
  CHECK(scene.body_name(2) == "crate");
  CHECK(scene.body_name(3).empty());
  CHECK(scene.body(0).shape == Shape::kCapsule);
  CHECK(scene.body(1).shape == Shape::kPlane);
  CHECK(scene.body(1).fixed);
  const BodyInfo crate = scene.body(2);
  CHECK(crate.shape == Shape::kBox);
  CHECK(crate.half_extents_m == Vector3{0.05, 0.1, 0.2});
  CHECK(crate.mass_kg == 3);
  CHECK(crate.inertia_kg_m2[0] == Approx(3.0 / 12 * (0.2 * 0.2 + 0.4 * 0.4)));
  CHECK(crate.friction == 0.25);
  CHECK(crate.position_m == Vector3{1, 2, 3});
  CHECK(crate.rotation == Quaternion{1, 0, 0, 0});
  CHECK(scene.body(77).mass_kg == 0);
  CHECK(scene.corners(2).empty());
}

TEST_CASE("a scene with mistakes names all of them, and leaves what was read before") {
  Scene scene = scene_of("press.toml");
  const std::string title = scene.title();
  const Error error = scene.parse("title = 3\n[proxy]\nshape = \"ball\"\n", "broken");
  CHECK(error.kind() == Error::Kind::kFile);
  CHECK_THAT(error.message(), Contains("broken:1") && Contains("broken:3") && Contains("accepted"));
  CHECK(scene.title() == title);
  const Scene copy = scene;
  CHECK(copy.bodies() == scene.bodies());
}

TEST_CASE("hulls and meshes have corners, meshes triangles of them") {
  unsigned hulls = 0, meshes = 0;
  for (const char* name : {"stones.toml", "terrain.toml"}) {
    const Scene scene = scene_of(name);
    for (BodyNumber body = 0; body < scene.bodies(); ++body) {
      const Shape shape = scene.body(body).shape;
      hulls += shape == Shape::kHull ? 1 : 0;
      meshes += shape == Shape::kMesh ? 1 : 0;
      CHECK((scene.corners(body).size() >= 4) == (shape == Shape::kHull || shape == Shape::kMesh));
      CHECK(scene.triangles(body).empty() == (shape != Shape::kMesh));
      for (const auto& triangle : scene.triangles(body))
        if (triangle[0] >= scene.corners(body).size()) FAIL("a corner that there is not");
      if (meshes > 0) break;
    }
  }
  CHECK(hulls > 0);
  CHECK(meshes > 0);
}
