#include "sim/broad_phase/box_grid.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <map>

#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::sim;
using physics::Aabb;
using tactus::test::Random;

namespace {

Aabb box_at(const Vec3d& centre, const Vec3d& half) { return {centre - half, centre + half}; }

std::vector<std::uint32_t> found_in(const BoxGrid& grid, const Aabb& box) {
  std::vector<std::uint32_t> found;
  grid.find(box, [&](std::uint32_t body) { found.push_back(body); });
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

TEST_CASE("A grid of boxes finds what the brute-force test finds while boxes of all sizes come and go") {
  constexpr std::uint32_t kBodies = 500;
  Random random(5);
  BoxGrid grid(kBodies);
  std::map<std::uint32_t, Aabb> inside;
  std::size_t hits = 0;
  for (int k = 0; k < 6000; ++k) {
    const auto body = static_cast<std::uint32_t>(random(0, kBodies));
    if (inside.count(body) != 0) {
      grid.remove(body);
      inside.erase(body);
    } else {
      // From a millimetre to ten metres.
      const double size = std::pow(10.0, random(-3, 1));
      inside[body] = box_at(random.vector(k % 7 == 0 ? 1000 : 3), size * abs(random.vector(0.5)));
      grid.insert(body, inside[body]);
    }
    REQUIRE(grid.size() == inside.size());
    const Aabb box = box_at(random.vector(4), std::pow(10.0, random(-3, 1)) * abs(random.vector(0.5)));
    std::vector<std::uint32_t> expected;
    for (const auto& [other, bounds] : inside)
      if (bounds.overlaps(box)) expected.push_back(other);
    REQUIRE(found_in(grid, box) == expected);
    hits += expected.size();
  }
  CHECK(hits > 1000);
}

TEST_CASE("Boxes on the borders of cells, far out, without end and without size are found") {
  BoxGrid grid(8);
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  grid.insert(0, box_at({0.5, 0.5, 0.5}, {0.5, 0.5, 0.5}));
  grid.insert(1, box_at({1.5, 0.5, 0.5}, {0.5, 0.5, 0.5}));
  grid.insert(2, box_at({-0.25, -0.25, -0.25}, {0.25, 0.25, 0.25}));
  grid.insert(3, box_at({1e9, 0, 0}, {0.1, 0.1, 0.1}));
  grid.insert(4, {{-kInfinity, -kInfinity, -1}, {kInfinity, kInfinity, -0.9}});
  grid.insert(5, box_at({3, 3, 3}, {0, 0, 0}));
  CHECK(found_in(grid, box_at({1, 0.5, 0.5}, {0, 0, 0})) == std::vector<std::uint32_t>{0, 1});
  CHECK(found_in(grid, box_at({0, 0, 0}, {0, 0, 0})) == std::vector<std::uint32_t>{0, 2});
  CHECK(found_in(grid, box_at({1e9, 0, 0}, {1, 0.5, 0.5})) == std::vector<std::uint32_t>{3});
  CHECK(found_in(grid, box_at({3, 3, 3}, {0, 0, 0})) == std::vector<std::uint32_t>{5});
  CHECK(found_in(grid, box_at({40, 0, -1}, {0.1, 0.1, 0.01})) == std::vector<std::uint32_t>{4});
  CHECK(found_in(grid, {{-kInfinity, -kInfinity, -kInfinity}, {kInfinity, kInfinity, kInfinity}}).size() == 6);
  grid.remove(0);
  CHECK(found_in(grid, box_at({1, 0.5, 0.5}, {0, 0, 0})) == std::vector<std::uint32_t>{1});
}
