#include "tools/experiment/stirrer.h"

#include <catch2/catch.hpp>

#include <cmath>

#include "tools/experiment/quality.h"

using namespace tactus;
using namespace tactus::experiment;

TEST_CASE("The rods' velocity is the change of their place, and takes them there in a step") {
  const Stirrer stirrer = make_stirrer(1000, 0.1);
  REQUIRE(stirrer.centres_m.size() == 16);
  const double h = 1e-6, time = 0.7, step = 1e-2;
  for (std::size_t rod = 0; rod < stirrer.centres_m.size(); ++rod) {
    const Vec3d change = stirrer.pose_at(rod, time + h).position - stirrer.pose_at(rod, time - h).position;
    CHECK(norm((0.5 / h) * change - stirrer.velocity_at(time).linear) < 1e-8);
    const Vec3d here = stirrer.pose_at(rod, time).position;
    const Vec3d there = here + step * stirrer.velocity_over(rod, here, time, step).linear;
    CHECK(norm(there - stirrer.pose_at(rod, time + step).position) < 1e-15);
  }
  CHECK(stirrer.path_length_m(2) == Approx(2 * norm(stirrer.velocity_at(0).linear)));
}

TEST_CASE("The rods stay over the floor of their bowl, reach into it, and the heap starts above them") {
  for (const char* name : {"pile64-stirred", "pile1000-stirred", "pile5000-stirred", "pile10000-stirred"}) {
    const auto scene = make_scene(name, true);
    REQUIRE(scene);
    REQUIRE(scene->stirrer);
    const Stirrer& stirrer = *scene->stirrer;
    const double half_floor = 0.5 * floor_width(stirrer, scene->cubes.front().edge_m);
    for (const Vec3d& centre : stirrer.centres_m) {
      const double reach =
          std::max(std::abs(centre.x), std::abs(centre.y)) + stirrer.radius_m + stirrer.half_extents_m.x;
      REQUIRE(reach < half_floor);
      REQUIRE(centre.z < stirrer.half_extents_m.z);
    }
    const double top = stirrer.centres_m.front().z + stirrer.half_extents_m.z;
    for (const Cube& cube : scene->cubes) REQUIRE(cube.position.z > top);
    // Each side's surface begins at the edge of the floor and slopes up and outwards.
    REQUIRE(scene->walls.size() == 5);
    for (std::size_t w = 1; w < 5; ++w) {
      const Wall& wall = scene->walls[w];
      const Vec3d normal = rotate(wall.rotation, Vec3d{0, 0, 1}), out = {-normal.x, -normal.y, 0};
      REQUIRE(normal.z > 0.5);
      REQUIRE(dot(out, wall.position) > 0);
      const Vec3d edge = (half_floor / norm(out)) * out;
      REQUIRE(dot(normal, edge - wall.position) == Approx(wall.half_extents_m.z));
    }
  }
}

TEST_CASE("What is in a wall, under the floor or beyond all walls has left the box") {
  const auto scene = make_scene("pile64-stirred", true);
  REQUIRE(scene);
  for (const Vec3d& gone : {Vec3d{0, 0, -0.06}, Vec3d{0, 0, -9}, Vec3d{1.5, 0, 0.1}, Vec3d{0, 99, 1}}) {
    BoxScene changed = *scene;
    changed.cubes[3].position = gone;
    QualitySampler sampler(changed);
    const auto engine = make_tactus(changed, {});
    sampler.start(*engine);
    sampler.sample(*engine);
    CHECK(sampler.result().escaped == 1);
  }
}

// The same rods in every engine: where they are to be, and what they push goes as far, within a factor of two.
TEST_CASE("The rods are where they are prescribed in every engine, and push as much") {
  const auto scene = make_scene("pile64-stirred", true);
  REQUIRE(scene);
  const int falls = 1000, stirs = 1500, between = 50;
  std::vector<double> travels;
  for (const EngineKind& kind : engine_kinds()) {
    if (!kind.available) continue;
    INFO(kind.name);
    const auto engine = kind.make(*scene, {.tuned = kind.tuned});
    QualitySampler sampler(*scene);
    int steps = 0;
    const auto advance = [&](int count) {
      for (int i = 0; i < count; ++i) engine->step();
      steps += count;
    };
    advance(falls);
    sampler.start(*engine);
    for (int done = 0; done < stirs; done += between) {
      advance(between);
      sampler.sample(*engine);
      const auto rods = engine->rods();
      REQUIRE(rods.size() == 1);
      const Posed wanted = scene->stirrer->pose_at(0, steps * scene->step_s);
      REQUIRE(norm(rods[0].position - wanted.position) < 1e-5);
      REQUIRE(norm(rods[0].rotation.vec()) < 1e-6);
    }
    const Quality quality = sampler.result();
    CHECK(quality.escaped == 0);
    CHECK(quality.rod_travel_m == Approx(scene->stirrer->path_length_m(stirs * scene->step_s)).epsilon(0.01));
    CHECK(quality.travel_m > 2 * kMinTravelShare * quality.rod_travel_m);
    travels.push_back(quality.travel_m);
  }
  const auto [least, most] = std::minmax_element(travels.begin(), travels.end());
  CHECK(*most < 2 * *least);
}
