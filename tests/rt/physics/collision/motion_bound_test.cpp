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
