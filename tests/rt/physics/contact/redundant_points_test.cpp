// Blocks of slices move as the box that they are: at rest, in an impact, over a seam.
#include "rt/physics/contact/redundant_points.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <memory>

#include "rt/physics/effects/restitution.h"
#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::kGravity;

namespace {

// A box of n slices beside each other along x.
struct Block {
  std::vector<CompoundPart> parts;
  std::vector<Compound> list;

  Block(int n, const Vec3d& half) {
    const Shape whole = Shape::box(half);
    for (int i = 0; i < n; ++i)
      parts.push_back({Shape::box({half.x / n, half.y, half.z}), {{half.x * ((2 * i + 1.0) / n - 1), 0, 0}, {}}});
    Compound compound;
    compound.parts = parts;
    compound.half_extents = half;
    compound.bounding_radius = bounding_radius(whole);
    compound.half_thickness = half_thickness(parts[0].shape);
    compound.volume = volume_of(whole);
    compound.inertia_per_kg = inertia_of(whole, 1);
    list.push_back(compound);
  }
  Shape shape() const { return compound_shape(list[0], 0); }
  Body body(BodyId id, double mass, const Posed& pose) const {
    Body made = make_dynamic_body(id, shape(), mass, 0.5, pose);
    made.inertia = mass * list[0].inertia_per_kg;
    return made;
  }
};

struct Bench {
  const Block& block;
  std::vector<double> coefficients{0.8, 0.8};
  World world;
  StepSettings settings;
  StepReport report;

  explicit Bench(const Block& of, bool bounces = false)
      : block(of),
        world({.bodies = 16, .fixed_bodies = 4, .pairs = 8192, .contacts = 8192}, {{}, {}, of.list}, effects(bounces)) {
    settings.gravity = {0, 0, -kGravity};
  }
  EffectSetups effects(bool bounces) const {
    EffectSetups setups;
    if (bounces) std::get<Restitution::Setup>(setups) = {coefficients};
    return setups;
  }
  void step() {
    world.begin_step(settings);
    find_pairs_brute_force(world.bounds(), world.dynamic_pairs());
    report = world.finish_step(settings, {});
  }
  const BodyMotion& motion(BodyId id) { return world.find(id)->motion; }
  std::uint32_t solved_points() const {
    std::uint32_t points = 0;
    for (const Contact& contact : world.contacts())
      for (std::uint32_t i = 0; i < contact.count; ++i) points += contact.points[i].redundant ? 0 : 1;
    return points;
  }
};

}  // namespace

TEST_CASE("A stack of blocks stands as deep and as still as one of boxes, however many slices they have", "[slow]") {
  const Vec3d half{0.04, 0.04, 0.04};
  const auto run = [&](int slices, double step_s, std::uint32_t sub_steps, double hertz) {
    const Block block(slices, half);
    auto bench = std::make_unique<Bench>(block);
    bench->settings.dt = step_s;
    bench->settings.sub_steps = sub_steps;
    bench->settings.contact_hertz = hertz;
    bench->world.insert(make_fixed_body(99, Shape::plane(), 0.5, {}));
    for (BodyId id = 0; id < 8; ++id) bench->world.insert(block.body(id, 0.2, {{0, 0, 0.04 + 0.08 * id}, {}}));
    for (int i = 0; i < std::lround(3.0 / step_s); ++i) bench->step();
    CAPTURE(slices, step_s);
    CHECK(bench->world.kinetic_energy() < 1e-12);  // before: 1e-4 J with eight slices
    CHECK(bench->solved_points() == 8 * 4);
    return bench->motion(7).pose.position.z;
  };
  const double plain = run(1, 0.01, 10, 200), fine = run(1, 1e-3, 4, 250);
  for (const int slices : {2, 3, 4, 8, 16}) {
    CHECK(run(slices, 0.01, 10, 200) == Approx(plain).margin(1e-6));
    CHECK(run(slices, 1e-3, 4, 250) == Approx(fine).margin(1e-6));
  }
}

TEST_CASE("A block of slices that falls flat bounces as a box does, and a box on a plate of slices too") {
  const Vec3d half{0.04, 0.04, 0.04};
  for (const int slices : {1, 2, 3, 4, 8})
    for (const bool block_falls : {true, false}) {
      CAPTURE(slices, block_falls);
      const Block block(slices, half);
      Bench bench(block, true);
      const double height = 0.1;
      if (block_falls) {
        bench.world.insert(make_fixed_body(0, Shape::plane(), 0.5, {}));
        bench.world.insert(block.body(1, 0.2, {{0, 0, 0.04 + height}, {}}));
      } else {
        bench.world.insert(make_fixed_body(0, block.shape(), 0.5, {{0, 0, -0.04}, {}}));
        bench.world.insert(make_dynamic_body(1, Shape::box({0.03, 0.03, 0.04}), 0.2, 0.5, {{0, 0, 0.04 + height}, {}}));
      }
      double top = 0, spin = 0;
      bool bounced = false;
      for (int i = 0; i < 400 && !(bounced && bench.motion(1).velocity.linear.z < 0); ++i) {
        bench.step();
        bounced = bounced || bench.motion(1).velocity.linear.z > 0;
        if (bounced) top = std::max(top, bench.motion(1).pose.position.z - 0.04);
        spin = std::max(spin, norm(bench.motion(1).velocity.angular));
      }
      CHECK(top == Approx(0.64 * height).epsilon(0.01));
      CHECK(spin < 1e-3);  // before: 27 rad/s with three slices
    }
}

TEST_CASE("A box slides over the flush seams of a body without a bump") {
  for (const int slices : {2, 3, 8}) {
    CAPTURE(slices);
    const Block block(slices, {0.5, 0.1, 0.05});
    Bench bench(block);
    bench.world.insert(make_fixed_body(0, block.shape(), 0, {{0, 0, -0.05}, {}}));
    Body box = make_dynamic_body(1, Shape::box({0.03, 0.03, 0.02}), 0.1, 0, {{-0.4, 0, 0.02}, {}});
    box.motion.velocity.linear = {1, 0, 0};
    bench.world.insert(box);
    for (int i = 0; i < 800; ++i) {
      bench.step();
      REQUIRE(bench.motion(1).velocity.linear.x == Approx(1).epsilon(1e-3));  // before: thrown back at 0.1 m/s
      REQUIRE(bench.motion(1).pose.position.z == Approx(0.02).margin(3e-5));
      REQUIRE(norm(bench.motion(1).velocity.angular) < 0.02);
    }
  }
}

TEST_CASE("Points that carry something of their own are not redundant") {
  // A step of 1 mm between two slices, and a box that lies on both: the lower slice is not touched.
  const Vec3d half{0.05, 0.05, 0.02};
  Block block(2, half);
  block.parts[1].body_from_part.position.z = -1e-3;
  block.list[0].parts = block.parts;
  Bench bench(block);
  bench.world.insert(make_fixed_body(0, block.shape(), 0.5, {{0, 0, -0.02}, {}}));
  bench.world.insert(make_dynamic_body(1, Shape::box({0.04, 0.04, 0.02}), 0.2, 0.5, {{0.008, 0, 0.02}, {}}));
  for (int i = 0; i < 2000; ++i) bench.step();
  // It has tilted about the edge x = 0, until its far end lies on the lower slice, 48 mm away.
  const Vec3d up = rotate(bench.motion(1).pose.rotation, Vec3d{0, 0, 1});
  CHECK(up.x == Approx(1e-3 / 0.048).epsilon(0.05));
  CHECK(bench.world.kinetic_energy() < 1e-9);
}
