// What the tests of meshes share: grids of triangles, and a world that stands on one.
#pragma once

#include <catch2/catch.hpp>
#include <functional>

#include "rt/physics/collision/collide_mesh.h"
#include "rt/physics/world.h"
#include "sim/geometry/mesh_builder.h"
#include "tests/rt/physics/collision/collide_support.h"

namespace tactus::sim::support {

using tactus::test::Random;

inline constexpr double kGravity = 9.81;

// Heights over a square of n x n cells about the origin; each cell has two triangles, its diagonal as `diagonal` says.
inline TriangleSoup height_field(unsigned n, double cell_m, const std::function<double(double, double)>& height,
                                 const std::function<bool()>& diagonal) {
  TriangleSoup soup;
  for (unsigned j = 0; j <= n; ++j)
    for (unsigned i = 0; i <= n; ++i) {
      const double x = (i - 0.5 * n) * cell_m, y = (j - 0.5 * n) * cell_m;
      soup.corners.push_back({x, y, height(x, y)});
    }
  for (unsigned j = 0; j < n; ++j)
    for (unsigned i = 0; i < n; ++i) {
      const unsigned a = j * (n + 1) + i, b = a + 1, c = b + n + 1, d = a + n + 1;
      if (diagonal()) {
        soup.triangles.push_back({a, b, c});
        soup.triangles.push_back({a, c, d});
      } else {
        soup.triangles.push_back({a, b, d});
        soup.triangles.push_back({b, c, d});
      }
    }
  return soup;
}

inline TriangleSoup flat_grid(unsigned n, double cell_m, std::uint32_t seed) {
  Random random(seed);
  return height_field(
      n, cell_m, [](double, double) { return 0.0; }, [&random] { return random.below(2) == 0; });
}

// A box from twelve triangles, outside out.
inline TriangleSoup box_soup(const Vec3d& half) {
  TriangleSoup soup;
  for (unsigned k = 0; k < 8; ++k)
    soup.corners.push_back(
        {(k & 1u) != 0 ? half.x : -half.x, (k & 2u) != 0 ? half.y : -half.y, (k & 4u) != 0 ? half.z : -half.z});
  constexpr unsigned faces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (const auto& f : faces) {
    soup.triangles.push_back({f[0], f[1], f[2]});
    soup.triangles.push_back({f[0], f[2], f[3]});
  }
  return soup;
}

inline BuiltMesh built(const TriangleSoup& soup) {
  auto mesh = build_mesh(weld(soup), physics::kFirstPatchId);
  INFO(mesh.message());
  REQUIRE(mesh.ok());
  return std::move(mesh).value();
}

// A world with a mesh, body 0, and bodies that are put on it.
struct MeshBench {
  explicit MeshBench(const TriangleSoup& soup, double friction = 0.5, const Posed& world_from_soup = {})
      : MeshBench(built(soup), friction, world_from_soup) {}
  MeshBench(BuiltMesh made, double friction, const Posed& world_from_soup)
      : parts(made.parts), meshes{made.mesh}, world(capacities(), {{}, meshes, {}}) {
    world.insert(physics::make_fixed_body(0, physics::Shape::mesh(meshes[0].half_extents, 0), friction,
                                          world_from_soup * made.given_from_body));
    settings.gravity = {0, 0, -kGravity};
  }

  static physics::Capacities capacities() {
    physics::Capacities c;
    c.bodies = 16;
    c.pairs = 1024;
    c.contacts = 512;
    c.mesh_triangles = 4096;
    return c;
  }

  physics::Body& add(const physics::Shape& shape, double mass, double friction, const Posed& pose) {
    const auto id = static_cast<BodyId>(world.bodies().size() + 1);
    REQUIRE(world.insert(physics::make_dynamic_body(id, shape, mass, friction, pose)));
    return world.bodies()[world.bodies().size() - 1];
  }
  void step() {
    world.begin_step(settings);
    find_pairs_brute_force(world.bounds(), world.dynamic_pairs());
    report = world.finish_step(settings);
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) step();
  }
  const physics::Mesh& mesh() const { return meshes[0]; }

  std::shared_ptr<const MeshParts> parts;
  std::vector<physics::Mesh> meshes;
  physics::World world;
  physics::StepSettings settings;
  physics::StepReport report;
};

}  // namespace tactus::sim::support
