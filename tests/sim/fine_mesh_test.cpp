// Bodies on meshes whose triangles are many more than a body may touch.
#include "rt/physics/shapes/body_on_mesh.h"
#include "tests/sim/geometry/mesh_support.h"

using namespace tactus;
using namespace tactus::sim;
using namespace tactus::sim::support;
using physics::Shape;

namespace {

// Heights at random, so that each triangle is a patch.
TriangleSoup rough_grid(unsigned n, double cell_m, double height_m, std::uint32_t seed) {
  Random random(seed);
  return height_field(
      n, cell_m, [&](double, double) { return random(-height_m, height_m); }, [&] { return random.below(2) == 0; });
}

double least_separation(const physics::Manifold& m) {
  double least = 1;
  for (std::uint32_t i = 0; i < m.count; ++i) least = std::min(least, m.points[i].separation);
  return least;
}

}  // namespace

TEST_CASE("a body on a flat mesh has the contact of a plane, however small the triangles are") {
  const double friction = 0.3, speed = 0.5;
  const Quatd lying = quat_from_rotation_vector(Vec3d{0, 1.5707963267948966, 0});
  for (const unsigned cells : {40u, 150u, 300u}) {  // of 0.9 m: the box is above 1,400 to 80,000 triangles
    CAPTURE(cells);
    const BuiltMesh ground = built(flat_grid(cells, 0.9 / cells, 2));
    struct Case {
      Shape shape;
      Posed start;
    };
    const Case cases[] = {{Shape::box({0.2, 0.2, 0.05}), {{-0.1, 0, 0.05}, {}}},
                          {Shape::cylinder(0.2, 0.05), {{-0.1, 0, 0.05}, {}}},
                          {Shape::cone(0.2, 0.05), {{-0.1, 0, 0.025}, {}}},
                          {Shape::capsule(0.05, 0.2), {{-0.1, 0, 0.05}, lying}}};
    for (const Case& c : cases) {
      CAPTURE(static_cast<int>(c.shape.kind));
      MeshBench each(ground, friction, {});
      auto& body = each.add(c.shape, 2.0, friction, c.start);
      body.motion.velocity.linear = {speed, 0, 0};
      for (int i = 0; i < 400; ++i) {
        each.step();
        REQUIRE((each.report.capacity_bits & physics::kMeshTrianglesFull) == 0);
      }
      CHECK(body.motion.pose.position.z == Approx(c.start.position.z).margin(5e-5));
      const double way = body.motion.pose.position.x - c.start.position.x;
      CHECK(way == Approx(speed * speed / (2 * friction * kGravity)).epsilon(0.03));
      CHECK(norm(body.motion.velocity.linear) < 1e-3);
    }
  }
}

TEST_CASE("the triangles that a body can touch give the contacts that all triangles give") {
  Random random(31);
  // Plateaus with steps between them, and a slope: flat patches with rims of every kind.
  const BuiltMesh made = built(height_field(
      40, 0.02, [](double x, double y) { return x > 0.15   ? 0.05
                                                : y > 0.1  ? -0.04
                                                : x < -0.2 ? 0.3 * (x + 0.2)
                                                           : 0.0; },
      [&random] { return random.below(2) == 0; }));
  const physics::Mesh& ground = made.mesh;
  const Shape shapes[] = {Shape::box({0.12, 0.08, 0.03}), Shape::sphere(0.1), Shape::capsule(0.03, 0.12),
                          Shape::cylinder(0.1, 0.04), Shape::cone(0.1, 0.06)};
  unsigned touching = 0, skipped = 0;
  for (int n = 0; n < 6000; ++n) {
    const Shape& shape = shapes[n % 5];
    const Quatd turned = n % 3 == 0 ? Quatd{} : random.rotation();
    const double reach = 2e-3;
    const Posed pose{{random(-0.35, 0.35), random(-0.35, 0.35), random(-0.02, 0.12)}, turned};
    physics::BodyOnMesh body(ground, {shape, pose}, reach, {});
    const auto box = bounds_of(shape, pose, reach);
    for (const physics::MeshNode& node : ground.nodes)
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
        if (node.inside_patch != physics::kNoPatch && body.can_touch(ground.order[i])) REQUIRE(body.can_touch(node));
    std::vector<std::uint32_t> all, some;
    const auto compare = [&] {
      if (all.empty()) return;
      const auto collide = [&](const std::vector<std::uint32_t>& triangles) {
        return physics::collide_patch({shape, pose}, {ground, Posed{}, triangles}, {.margin = reach});
      };
      const physics::Manifold expected = collide(all);
      physics::Manifold got = some.empty() ? physics::Manifold{} : collide(some);
      CAPTURE(n, all.size(), some.size());
      // Deeper, the kernel also gives points above which the body is not: the box about the body leaves them out.
      if (expected.count > 0 && least_separation(expected) < -3e-3) {
        all.clear();
        some.clear();
        return;
      }
      REQUIRE((got.count > 0) == (expected.count > 0));
      touching += expected.count > 0 ? 1 : 0;
      skipped += static_cast<unsigned>(all.size() - some.size());
      if (shape.kind != physics::ShapeKind::kCapsule) REQUIRE(got.count == expected.count);
      if (shape.kind == physics::ShapeKind::kCapsule && got.count != expected.count) {
        CHECK(least_separation(got) == Approx(least_separation(expected)).margin(1e-9));
        got.count = 0;
      }
      for (std::uint32_t i = 0; i < got.count; ++i) {
        CHECK(norm(got.points[i].from_a - expected.points[i].from_a) < 1e-9);
        CHECK(got.points[i].separation == Approx(expected.points[i].separation).margin(1e-9));
      }
      all.clear();
      some.clear();
    };
    for (std::uint32_t t = 0; t < ground.triangles.size(); ++t) {  // patch by patch
      if (t > 0 && ground.triangles[t].patch != ground.triangles[t - 1].patch) compare();
      if (!ground.box_of(t).overlaps(box)) continue;
      all.push_back(t);
      if (body.can_touch(t)) some.push_back(t);
    }
    compare();
  }
  CHECK(touching > 250);
  CHECK(skipped > 10000);
}

TEST_CASE("a box that falls on its edge onto a fine mesh lands where it would on a plane") {
  const Quatd on_edge = quat_from_rotation_vector(Vec3d{0, 0.6, 0});
  MeshBench fine(flat_grid(200, 0.005, 4));
  auto& body = fine.add(Shape::box({0.2, 0.2, 0.05}), 2.0, 0.5, {{0, 0, 0.3}, on_edge});
  fine.run(1500);
  CHECK(body.motion.pose.position.z == Approx(0.05).margin(1e-4));
  CHECK(norm(body.motion.velocity.linear) < 1e-3);
}

TEST_CASE("bodies that touch too many triangles keep the nearest, and that is reported") {
  MeshBench bench(rough_grid(60, 0.002, 2e-5, 2));
  auto& body = bench.add(Shape::box({0.05, 0.05, 0.01}), 1.0, 0.5, {{0, 0, 0.01}, {}});
  bench.run(3);
  CHECK((bench.report.capacity_bits & physics::kMeshTrianglesFull) != 0);
  CHECK(bench.report.dropped > 0);
  bench.run(500);
  CHECK(body.motion.pose.position.z == Approx(0.01).margin(1e-4));
}
