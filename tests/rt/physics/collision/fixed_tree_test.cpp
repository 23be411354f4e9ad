#include "rt/physics/collision/fixed_tree.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>

#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::PhysicsBench;
using tactus::test::Random;

TEST_CASE("The tree of static geometry finds what the brute-force test finds, and lists what has no bounds") {
  for (const std::uint32_t count : {1u, 2u, 3u, 17u, 300u}) {
    Random random(count);
    std::vector<Aabb> boxes;
    for (std::uint32_t i = 0; i < count; ++i) {
      const Vec3d centre = random.vector(2), half = abs(random.vector(0.3));
      boxes.push_back({centre - half, centre + half});
    }
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const Vec3d everywhere{kInfinity, kInfinity, kInfinity};
    boxes.insert(boxes.begin() + count / 2, {-1.0 * everywhere, everywhere});
    FixedTree tree(count + 1);
    tree.build(boxes);
    CHECK(std::vector<std::uint32_t>(tree.unbounded().begin(), tree.unbounded().end()) ==
          std::vector<std::uint32_t>{count / 2});
    std::size_t hits = 0;
    for (int k = 0; k < 200; ++k) {
      const Vec3d centre = random.vector(2.5), half = abs(random.vector(0.4));
      const Aabb box{centre - half, centre + half};
      std::vector<std::uint32_t> found, expected;
      tree.find(box, [&](std::uint32_t slot) {
        found.push_back(slot);
        return true;
      });
      std::sort(found.begin(), found.end());
      for (std::uint32_t i = 0; i < boxes.size(); ++i)
        if (i != count / 2 && boxes[i].overlaps(box)) expected.push_back(i);
      REQUIRE(found == expected);
      hits += found.size();
    }
    CHECK((hits > 0 || count < 17));
  }
}

TEST_CASE("Bodies rest on the one of many fixed blocks that is under them, also one that came later") {
  PhysicsBench bench({64, 512, 512, 256, 0});
  for (BodyId i = 0; i < 400; ++i)
    bench.world.insert(
        make_fixed_body(i, Shape::box({0.1, 0.1, 0.1}), 0.5, {{0.3 * (i % 20), 0.3 * (i / 20), -0.1}, {}}));
  for (const BodyId block : {7u, 133u, 399u})
    bench.add_sphere(1000 + block, 0.05, 1, 0.5, {0.3 * (block % 20), 0.3 * (block / 20), 0.05});
  bench.run_seconds(0.5);
  for (const BodyId block : {7u, 133u, 399u}) CHECK(bench.position(1000 + block).z == Approx(0.05).margin(1e-4));
  bench.world.insert(make_fixed_body(500, Shape::box({0.1, 0.1, 0.1}), 0.5, {{-3, 0, -0.1}, {}}));
  bench.add_sphere(2000, 0.05, 1, 0.5, {-3, 0, 0.05});
  bench.run_seconds(0.5);
  CHECK(bench.position(2000).z == Approx(0.05).margin(1e-4));
  bench.world.remove(133);
  bench.run_seconds(0.5);
  CHECK(bench.position(1133).z < -0.5);
}
