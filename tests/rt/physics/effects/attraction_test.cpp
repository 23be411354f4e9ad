// The effect attraction: orbits, softening, action and reaction.
#include "rt/physics/effects/attraction.h"

#include <catch2/catch.hpp>
#include <vector>

#include "rt/physics/world.h"
#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::kPi;

namespace {

struct Field {
  std::vector<double> weight;
  EffectSetups setups;
  StepSettings settings;
  Field(const AttractionSource& source, std::vector<double> weights) : weight(std::move(weights)) {
    auto& setup = std::get<Attraction::Setup>(setups);
    REQUIRE(setup.sources.try_push(source));
    setup.weight_by_id = weight;
  }
  void run(World& world, int steps) {
    for (int i = 0; i < steps; ++i) {
      world.begin_step(settings);
      (void)world.finish_step(settings);
    }
  }
};

Body ball(BodyId id, double mass, const Vec3d& at, const Vec3d& velocity) {
  auto made = make_dynamic_body(id, Shape::sphere(0.01), mass, 0, {at, {}});
  made.motion.velocity.linear = velocity;
  return made;
}

}  // namespace

TEST_CASE("About a source without softening a body goes round in 2 pi sqrt(m r^3 / strength)") {
  const double mass = 0.2, r = 0.5, strength = 0.3, w = std::sqrt(strength / (mass * r * r * r));
  Field field({kNoBody, {0, 0, 1}, strength, 1e-6}, {1.0});
  World world(Capacities{}, {}, field.setups);
  REQUIRE(world.insert(ball(0, mass, {r, 0, 1}, {0, w * r, 0})));
  const double period = 2 * kPi / w;
  const int steps = static_cast<int>(std::lround(period / field.settings.dt));
  field.run(world, steps);
  const double angle = w * steps * field.settings.dt - 2 * kPi;  // what rounding to whole steps leaves
  CHECK(world.bodies()[0].motion.pose.position.x == Approx(r * std::cos(angle)).epsilon(1e-3));
  CHECK(world.bodies()[0].motion.pose.position.y == Approx(r * std::sin(angle)).margin(2e-3));
  CHECK(norm(world.bodies()[0].motion.velocity.linear) == Approx(w * r).epsilon(1e-3));
}

TEST_CASE("Near a softened source a body swings as on a spring of strength / softening^3, one without weight stays") {
  const double mass = 0.2, soft = 0.1, strength = 0.02, w = std::sqrt(strength / (mass * soft * soft * soft));
  Field field({kNoBody, {}, strength, soft}, {1.0, 0.0});
  World world(Capacities{}, {}, field.setups);
  REQUIRE(world.insert(ball(0, mass, {0.001, 0, 0}, {})));
  REQUIRE(world.insert(ball(1, mass, {0.5, 0, 0}, {})));
  field.run(world, static_cast<int>(std::lround(kPi / w / field.settings.dt)));  // half a period: the other side
  CHECK(world.bodies()[0].motion.pose.position.x == Approx(-0.001).epsilon(5e-3));
  CHECK(world.bodies()[1].motion.pose.position.x == 0.5);
}

TEST_CASE("A source that is a body is pulled back: momentum stays") {
  Field field({1, {}, 0.5, 0.05}, {1.0, 0.0});
  World world(Capacities{}, {}, field.setups);
  REQUIRE(world.insert(ball(0, 0.2, {0.5, 0, 0}, {0, 0.3, 0})));
  REQUIRE(world.insert(ball(1, 1, {}, {})));
  const Vec3d before = world.momentum().force;
  field.run(world, 500);
  CHECK(norm(world.bodies()[1].motion.velocity.linear) > 0.01);
  CHECK(norm(world.momentum().force - before) < 1e-12);
}
