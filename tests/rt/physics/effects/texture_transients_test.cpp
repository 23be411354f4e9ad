// What the hand feels beyond its coupling: the grain of a surface, and an impact that rings.
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "rt/physics/world.h"
#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::kGravity;
using tactus::test::kPi;

namespace {

constexpr BodyId kProxy = 0, kTable = 1;
constexpr double kMass = 0.2, kRadius = 0.01, kDt = 1e-3;

// A smooth ball, the proxy, above or on a table whose top is z = 0.
struct Feeler {
  World world;
  StepSettings settings;
  StepReport report;
  explicit Feeler(const EffectSetups& setups, double height_m = 0) : world(Capacities{}, {}, setups) {
    settings.gravity = {0, 0, -kGravity};
    settings.friction = false;
    REQUIRE(
        world.insert(make_dynamic_body(kProxy, Shape::sphere(kRadius), kMass, 0, {{0, 0, kRadius + height_m}, {}})));
    REQUIRE(world.insert(make_fixed_body(kTable, Shape::box({1, 1, 0.05}), 0, {{0, 0, -0.05}, {}})));
  }
  BodyMotion& ball() { return world.bodies()[0].motion; }
  const Vec3d& step() {
    world.begin_step(settings);
    find_pairs_brute_force(world.bounds(), world.dynamic_pairs());
    report = world.finish_step(settings);
    return report.hand_wrench.force;
  }
};

struct Grained {
  std::vector<Grain> by_id;
  EffectSetups setups;
  explicit Grained(const Grain& grain) : by_id{{}, grain} { std::get<Texture::Setup>(setups) = {kProxy, by_id}; }
};

struct Rings {
  std::vector<Ringing> by_id;
  EffectSetups setups;
  explicit Rings(const Ringing& ringing) : by_id{{}, ringing} { std::get<Transients::Setup>(setups) = {kProxy, by_id}; }
};

}  // namespace

TEST_CASE("The grain pulls with N times the slope of its height, along the surface and downhill") {
  const double height = 1e-4, wavelength = 2e-3, k = 2 * kPi / wavelength;
  const Grained grained({height, wavelength});
  Feeler feeler(grained.setups);
  for (int i = 0; i < 300; ++i) (void)feeler.step();
  feeler.ball().velocity = {{0.1, 0.03, 0}, {}};
  double most = 0;
  for (int i = 0; i < 100; ++i) {
    const Vec3d felt = feeler.step(), at = feeler.ball().pose.position;
    const double press = kMass * kGravity * height * k;
    CHECK(felt.x == Approx(-press * std::cos(k * at.x)).margin(1e-3 * press));
    CHECK(felt.y == Approx(-press * std::cos(k * at.y)).margin(1e-3 * press));
    CHECK(felt.z == Approx(0).margin(1e-9));
    CHECK(norm(feeler.report.hand_wrench.torque - cross(Vec3d{0, 0, -kRadius}, felt)) < 1e-3 * press * kRadius);
    most = std::max(most, std::abs(felt.x));
  }
  CHECK(most == Approx(kMass * kGravity * height * k).epsilon(0.02));
  CHECK(feeler.ball().velocity.linear.x == Approx(0.1).epsilon(1e-6));  // the world knows nothing of it
}

TEST_CASE("A steady press gives back on the way out of a groove what it took on the way in: no work over whole waves") {
  const double wavelength = 2e-3, speed = 0.05;
  const Grained grained({1e-4, wavelength});
  Feeler feeler(grained.setups);
  for (int i = 0; i < 300; ++i) (void)feeler.step();
  feeler.ball().velocity = {{speed, 0, 0}, {}};
  double work = 0, largest = 0;
  for (int i = 0; i < static_cast<int>(std::lround(5 * wavelength / speed / kDt)); ++i) {
    work += feeler.step().x * speed * kDt;
    largest = std::max(largest, std::abs(work));
  }
  CHECK(largest > 1e-5);  // N h: 0.2 mJ to and fro
  CHECK(std::abs(work) < 1e-3 * largest);
}

TEST_CASE("Grain finer than the ticks resolve fades: half of it at 3/8 of a wave in a tick, nothing from 1/2 on") {
  const double wavelength = 2e-3;
  const Grained grained({1e-4, wavelength});
  const auto sideways = [&](double waves_in_a_tick) {
    Feeler feeler(grained.setups);
    for (int i = 0; i < 300; ++i) (void)feeler.step();
    feeler.ball().velocity = {{waves_in_a_tick * wavelength / kDt, 0, 0}, {}};
    return feeler.step().y;  // the slope across the way is the same everywhere
  };
  const double whole = sideways(0.1);
  CHECK(whole < -0.1);
  CHECK(sideways(0.375) == Approx(0.5 * whole).epsilon(1e-3));
  CHECK(sideways(0.5) == Approx(0).margin(1e-9));
}

TEST_CASE("An impact rings as A exp(-t / decay) sin(2 pi f t) along the normal, A by the speed of the impact") {
  const double strength = 4, frequency = 120, decay = 0.02;
  const Rings rings({strength, frequency, decay});
  for (const double speed : {0.1, 0.4}) {
    Feeler feeler(rings.setups, 1e-3);
    feeler.settings.gravity = {};
    feeler.ball().velocity.linear.z = -speed;
    int since = -1;
    for (int i = 0; i < 100; ++i) {
      const Vec3d felt = feeler.step();
      if (since < 0 && felt.z == 0) continue;
      const double t = kDt * (++since + 1);
      const double expected = strength * speed * std::exp(-t / decay) * std::sin(2 * kPi * frequency * t);
      CHECK(felt.z == Approx(expected).margin(1e-3 * strength * speed));
      CHECK((felt.x == 0 && felt.y == 0));
    }
    CHECK(since > 50);
  }
}

TEST_CASE(
    "What stays in touch does not ring again, what comes back does, and no more oscillations than there is room") {
  const Rings rings({5, 100, 0.003});
  Feeler feeler(rings.setups, 1e-3);
  const auto loudest = [&](int steps) {
    double most = 0;
    for (int i = 0; i < steps; ++i) most = std::max(most, norm(feeler.step()));
    return most;
  };
  CHECK(loudest(100) > 0.1);  // it falls by 1 mm
  CHECK(loudest(400) == 0);   // it lies
  feeler.ball().velocity.linear.z = 0.2;
  CHECK(loudest(10) == 0);
  CHECK(loudest(200) > 0.4);
  // Struck over and over while it rings.
  const Rings long_rings({5, 100, 1});
  Feeler drummer(long_rings.setups, 1e-3);
  double most = 0;
  for (int i = 0; i < 300; ++i) {
    if (i % 6 == 0) drummer.ball().velocity.linear.z = 0.3;
    if (i % 6 == 3) drummer.ball().velocity.linear.z = -0.5;
    most = std::max(most, norm(drummer.step()));
  }
  CHECK(most < 5 * 0.6 * Transients::kMaxRinging);
}

TEST_CASE("What still rings is part of the world's state") {
  const Rings rings({5, 130, 0.05});
  Feeler feeler(rings.setups, 1e-3);
  for (int i = 0; i < 30; ++i) (void)feeler.step();
  std::vector<std::byte> bytes(feeler.world.save_size_bound());
  ByteWriter out(bytes);
  feeler.world.save(out);
  REQUIRE(out.ok());
  Feeler other(rings.setups, 0.5);
  ByteReader in(std::span<const std::byte>(bytes).first(out.size()));
  REQUIRE(other.world.restore(in));
  for (int i = 0; i < 30; ++i) {
    const Vec3d felt = feeler.step();
    CHECK(norm(felt) > 0);
    CHECK(other.step() == felt);
  }
}
