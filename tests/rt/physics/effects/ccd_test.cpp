// Continuous collision for the proxy: fast as it may be, it passes no thin plate; slower, nothing changes.
#include "rt/physics/effects/ccd.h"

#include <catch2/catch.hpp>

#include "rt/physics/world.h"
#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;

namespace {

constexpr BodyId kProxy = 0, kPlate = 1;
constexpr double kRadius = 0.005, kMass = 0.2;

struct Range {
  World world;
  StepSettings settings;
  explicit Range(bool ccd) : world(Capacities{}, {}, setups(ccd)) {}
  static EffectSetups setups(bool ccd) {
    EffectSetups all;
    if (ccd) std::get<ContinuousCollision::Setup>(all).proxy = kProxy;
    return all;
  }
  // At x = 0 with its speed along +x.
  void add_proxy(double speed, double y = 0) {
    auto made = make_dynamic_body(kProxy, Shape::sphere(kRadius), kMass, 0.5, {{0, y, 0}, {}});
    made.motion.velocity.linear.x = speed;
    REQUIRE(world.insert(made));
  }
  Body plate(double at, double mass) const {
    const auto shape = Shape::box({0.0005, 0.1, 0.1});
    return mass > 0 ? make_dynamic_body(kPlate, shape, mass, 0.5, {{at, 0, 0}, {}})
                    : make_fixed_body(kPlate, shape, 0.5, {{at, 0, 0}, {}});
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) {
      world.begin_step(settings);
      find_pairs_brute_force(world.bounds(), world.dynamic_pairs());
      (void)world.finish_step(settings);
    }
  }
  const BodyMotion& proxy() const { return world.bodies()[0].motion; }
};

}  // namespace

TEST_CASE("At 30 to 200 m/s, wherever it is when a tick begins, the proxy stops at a plate of 1 mm") {
  int passed_without = 0;
  for (const double speed : {30.0, 60.0, 200.0})
    for (const double at : {0.05, 0.07, 0.09, 0.11, 0.13, 0.15, 0.3}) {
      Range with(true), without(false);
      with.add_proxy(speed);
      without.add_proxy(speed);
      REQUIRE(with.world.insert(with.plate(at, 0)));
      REQUIRE(without.world.insert(without.plate(at, 0)));
      double most = 0;
      for (int i = 0; i < 30; ++i) {
        with.run(1);
        most = std::max(most, with.proxy().pose.position.x);
      }
      without.run(30);
      INFO(speed << " m/s, plate at " << at << " m");
      CHECK(most < at - 0.0005 - kRadius + 0.5e-3);  // contacts give way
      CHECK(std::abs(with.proxy().velocity.linear.x) < 1e-6);
      passed_without += without.proxy().pose.position.x > at;
    }
  CHECK(passed_without > 10);
}

TEST_CASE("A plate that is free takes the proxy's momentum, and energy only falls") {
  Range range(true);
  range.add_proxy(60);
  REQUIRE(range.world.insert(range.plate(0.15, 1)));
  const double momentum = range.world.momentum().force.x;
  double energy = range.world.kinetic_energy();
  for (int i = 0; i < 50; ++i) {
    range.run(1);
    CHECK(range.world.kinetic_energy() <= energy * (1 + 1e-12));
    energy = range.world.kinetic_energy();
  }
  CHECK(range.world.momentum().force.x == Approx(momentum).epsilon(1e-12));
  const double together = 60 * kMass / (kMass + 1);
  CHECK(range.proxy().velocity.linear.x == Approx(together).epsilon(1e-6));
  CHECK(range.world.bodies()[1].motion.velocity.linear.x == Approx(together).epsilon(1e-6));
}

TEST_CASE("What flies past is not held back, and a slow proxy meets the plate bit by bit as without the effect") {
  Range past(true);
  past.add_proxy(60, 0.2);
  REQUIRE(past.world.insert(past.plate(0.15, 0)));
  past.run(10);
  CHECK(past.proxy().velocity.linear.x == 60);
  Range with(true), without(false);
  for (Range* range : {&with, &without}) {
    range->add_proxy(5);
    REQUIRE(range->world.insert(range->plate(0.15, 2)));
    range->run(100);
  }
  CHECK(with.world.state_hash() == without.world.state_hash());
}
