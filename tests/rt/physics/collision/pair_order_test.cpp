// The order of pairs and the wide finder, each against the plain way to say it.
#include "rt/physics/collision/pair_order.h"

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <utility>
#include <vector>

#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::Random;

namespace {

std::vector<std::pair<std::uint32_t, std::uint32_t>> list_of(const BoundedVector<SlotPair>& pairs) {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> list;
  for (const SlotPair& pair : pairs) list.emplace_back(pair.a, pair.b);
  return list;
}

}  // namespace

TEST_CASE("Pairs of slots are sorted, turned and made unique as by comparing") {
  Random random(1);
  PairOrder order(100, 3000);
  for (const std::uint32_t slots : {2u, 3u, 10u, 100u}) {
    for (const std::uint32_t count : {0u, 1u, 2u, 50u, 3000u}) {
      BoundedVector<SlotPair> pairs(3000);
      std::vector<std::pair<std::uint32_t, std::uint32_t>> expected;
      for (std::uint32_t n = 0; n < count; ++n) {
        const auto a = static_cast<std::uint32_t>(random(0, slots)), b = static_cast<std::uint32_t>(random(0, slots));
        if (a == b) continue;
        REQUIRE(pairs.try_push({a, b}));
        expected.emplace_back(std::min(a, b), std::max(a, b));
      }
      std::sort(expected.begin(), expected.end());
      expected.erase(std::unique(expected.begin(), expected.end()), expected.end());
      order.sort(pairs, slots);
      REQUIRE(list_of(pairs) == expected);
      order.sort(pairs, slots);  // what is sorted stays
      REQUIRE(list_of(pairs) == expected);
    }
  }
}

TEST_CASE("The wide finder finds exactly what overlaps, whatever single precision makes of it") {
  Random random(2);
  for (const std::uint32_t count : {1u, 2u, 7u, 8u, 9u, 64u, 333u, 1024u, 1025u}) {
    std::vector<Aabb> boxes;
    for (std::uint32_t i = 0; i < count; ++i) {
      // Faces a hundred millionth apart, and far from the origin: less than single precision can tell.
      const auto grid = [&] { return 1000 + 0.1 * std::floor(random(0, 8)) + 1e-8 * std::floor(random(-2, 3)); };
      const Vec3d at{grid(), grid(), grid()};
      boxes.push_back({at, at + Vec3d{0.1, 0.1, 0.1}});
    }
    if (count > 8) {
      const double infinity = std::numeric_limits<double>::infinity(), nan = std::nan("");
      boxes[3] = {{-infinity, -1e300, 1000}, {infinity, 1e300, 1000.2}};
      boxes[5] = {{1000, nan, 1000}, {1001, nan, 1001}};
    }
    BoundedVector<SlotPair> pairs(count * count);
    REQUIRE(find_pairs_brute_force(boxes, pairs));
    std::vector<std::pair<std::uint32_t, std::uint32_t>> expected;
    for (std::uint32_t a = 0; a < count; ++a)
      for (std::uint32_t b = a + 1; b < count; ++b)
        if (boxes[a].overlaps(boxes[b])) expected.emplace_back(a, b);
    REQUIRE(list_of(pairs) == expected);
  }
}
