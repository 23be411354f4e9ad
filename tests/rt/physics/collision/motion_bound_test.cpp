#include "rt/physics/collision/motion_bound.h"

#include <catch2/catch.hpp>

#include "tests/support/random.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::Random;

TEST_CASE("What a step may take from a distance covers bodies that go on and bodies that stop") {
  Random random(5);
  StepSettings settings;
  settings.max_margin = 10;
  for (int n = 0; n < 2000; ++n) {
    MotionBound a, b;
    for (MotionBound* bound : {&a, &b}) {
      bound->advance = random.vector(0.1);
      bound->rest = random(0, 0.01);
      bound->fallen = random(0, 0.01);
    }
    const Vec3d direction = random.direction();
    const double any = closing_of(a, b, settings), along = closing_along(direction, a, b, settings);
    REQUIRE(along <= any + 1e-12);
    const double rest = a.rest + b.rest + std::max(a.fallen, b.fallen);
    double most = 0;  // over all directions, from a search
    for (int k = 0; k < 200; ++k) {
      const Vec3d u = random.direction();
      most = std::max(most, closing_along(u, a, b, settings));
    }
    REQUIRE(most <= any + 1e-12);
    for (const double go_a : {0.0, 1.0})
      for (const double go_b : {0.0, 1.0}) {
        const double closed = dot(go_a * a.advance - go_b * b.advance, direction) + rest;
        REQUIRE(along >= closed - 1e-12);
      }
  }
}

TEST_CASE("The bound in any direction is reached by one of them") {
  StepSettings settings;
  settings.max_margin = 10;
  const auto bound = [&](const Vec3d& a, const Vec3d& b) {
    MotionBound x, y;
    x.advance = a;
    y.advance = b;
    return closing_of(x, y, settings);
  };
  CHECK(bound({1, 0, 0}, {1, 0, 0}) == Approx(1));   // side by side: the one in front may stop
  CHECK(bound({1, 0, 0}, {-1, 0, 0}) == Approx(2));  // head on
  CHECK(bound({1, 0, 0}, {0, 1, 0}) == Approx(std::sqrt(2.0)));
  CHECK(bound({0, 0, 0}, {0, 0, 0}) == 0);
  settings.max_margin = 0.5;
  CHECK(bound({1, 0, 0}, {-1, 0, 0}) == 0.5);
}

TEST_CASE("What a step may take from a point's distance to a fixed body covers every motion of the body") {
  Random random(6);
  StepSettings settings;
  settings.max_margin = 10;
  int less = 0;
  for (int n = 0; n < 5000; ++n) {
    MotionBound bound;
    const double radius = random(0.01, 0.2);
    const Vec3d at = random(0, radius) * random.direction(), direction = random.direction();
    bound.advance = random.vector(0.05);
    bound.turn = random.vector(0.5);
    bound.driven = random(0, 0.01);
    bound.fallen = random(0, 0.01);
    const double angle = norm(bound.turn);
    bound.rest = angle * radius + bound.driven;
    bound.curve = 0.5 * angle * angle * radius;
    const double closing = closing_to_fixed(bound, direction, dot(cross(bound.turn, at), direction), settings);
    const double whole = closing_along(direction, bound, {}, settings);
    REQUIRE(closing <= whole + 1e-12);
    less += closing < 0.7 * whole;
    // The body keeps any share of either velocity; a spring and gravity add to it.
    const Quatd turned = quat_from_rotation_vector(random(0, 1) * bound.turn);
    const double moved = dot(random(0, 1) * bound.advance + rotate(turned, at) - at, direction);
    REQUIRE(closing >= moved + bound.driven + bound.fallen - 1e-12);
  }
  CHECK(less > 1000);
  MotionBound rolls;  // a box that rolls over an edge: it falls in front, and lifts off behind
  rolls.turn = {0, 0.1, 0};
  rolls.rest = 0.01;
  const auto down_at = [&](const Vec3d& at) {
    const Vec3d down{0, 0, -1};
    return closing_to_fixed(rolls, down, dot(cross(rolls.turn, at), down), settings);
  };
  CHECK(down_at({0.05, 0, -0.05}) == Approx(0.005));
  CHECK(down_at({-0.05, 0, -0.05}) == 0);
}
