// How deep bodies lie in each other for how thick they are.
#include "rt/physics/overlap.h"

#include <catch2/catch.hpp>
#include <cmath>

#include "rt/physics/collision/pair_finder.h"

using namespace tactus;
using namespace tactus::physics;

namespace {

// A ball of 40 mm on a plane and a plate of 2 mm in another one, stepped once.
World two_overlaps(double ball_m, double plate_m) {
  World world({.bodies = 4, .fixed_bodies = 2, .pairs = 16, .contacts = 16});
  StepSettings settings;
  settings.gravity = {};
  REQUIRE(world.insert(make_fixed_body(9, Shape::plane(), 0, {})));
  REQUIRE(world.insert(make_dynamic_body(0, Shape::sphere(0.02), 1, 0, {{0, 0, 0.02 - ball_m}, {}})));
  REQUIRE(world.insert(make_dynamic_body(1, Shape::box({0.05, 0.05, 0.001}), 1, 0, {{1, 0, 1}, {}})));
  REQUIRE(world.insert(make_dynamic_body(2, Shape::box({0.05, 0.05, 0.1}), 1, 0, {{1, 0, 1.101 - plate_m}, {}})));
  world.begin_step(settings);
  (void)find_pairs_brute_force(world.bounds(), world.dynamic_pairs());
  (void)world.finish_step(settings);
  return world;
}

}  // namespace

TEST_CASE("a body's thickness is across its thinnest side, and a plane has none of its own") {
  CHECK(thickness(Shape::sphere(0.02)) == Approx(0.04));
  CHECK(thickness(Shape::capsule(0.01, 0.5)) == Approx(0.02));
  CHECK(thickness(Shape::box({0.1, 0.001, 0.05})) == Approx(0.002));
  CHECK(std::isinf(thickness(Shape::plane())));
  const Body bodies[] = {make_fixed_body(0, Shape::plane(), 0, {}),
                         make_dynamic_body(1, Shape::sphere(0.02), 1, 0, {})};
  CHECK(thinnest(bodies) == Approx(0.04));
}

TEST_CASE("the deepest share is found, which is not the deepest overlap") {
  const Overlap plate = deepest_overlap(two_overlaps(4e-3, 0.6e-3));
  CHECK(plate.share == Approx(0.3));
  CHECK(plate.depth == Approx(0.6e-3));
  CHECK(plate.a == 1);
  CHECK(plate.b == 2);
  const Overlap ball = deepest_overlap(two_overlaps(4e-3, 0.1e-3));
  CHECK(ball.share == Approx(0.1));
  CHECK(ball.a == 0);
  CHECK(ball.b == 9);
  CHECK(deepest_overlap(two_overlaps(-1e-3, -1e-3)).share == 0);
}
