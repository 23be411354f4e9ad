#include "sim/broad_phase/pair_cache.h"

#include <catch2/catch.hpp>
#include <limits>

#include "tests/sim/broad_phase/pair_support.h"
#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::sim;
using physics::Aabb;
using namespace tactus::test;

namespace {

Keys by_cache(PairCache& cache, const Boxes& boxes) {
  auto pairs = list_for_pairs(boxes);
  REQUIRE(cache.find(boxes, pairs));
  return sorted_keys(pairs);
}

Aabb moved(const Aabb& box, const Vec3d& by) { return {box.lower + by, box.upper + by}; }

// n boxes of 0.1 to 0.2 m, closely packed, one in fifty of 1 to 3 m.
Boxes heap(std::uint32_t n, Random& random) {
  Boxes boxes;
  const double side = 0.12 * std::cbrt(n);
  for (std::uint32_t i = 0; i < n; ++i) {
    const Vec3d centre = random.vector(side);
    const double size = i % 50 == 0 ? random(1, 3) : random(0.1, 0.2);
    const Vec3d half = 0.5 * size * Vec3d{random(0.5, 1), random(0.5, 1), random(0.5, 1)};
    boxes.push_back({centre - half, centre + half});
  }
  return boxes;
}

}  // namespace

TEST_CASE("Kept pairs are those of the brute-force test, whatever moves, comes and goes") {
  constexpr std::uint32_t kBodies = 300;
  Random random(3);
  PairCache cache(kBodies, kBodies * kBodies / 2);
  Boxes boxes = heap(kBodies, random);
  std::size_t hits = 0;
  for (int step = 0; step < 400; ++step) {
    const Keys expected = by_brute_force(boxes);
    REQUIRE(by_cache(cache, boxes) == expected);
    hits += expected.size();
    const bool all_move = step % 100 > 80;
    for (std::uint32_t i = 0; i < boxes.size(); ++i)
      if (all_move || i % 20 == 0)
        boxes[i] = moved(boxes[i], random.vector(0.05));
      else
        boxes[i] = moved(boxes[i], random.vector(1e-4));
    if (step % 37 == 36) boxes.resize(step % 2 == 0 ? kBodies / 2 : boxes.size());
    if (step % 50 == 49) boxes = heap(kBodies, random);
    if (step % 41 == 40) std::swap(boxes[3], boxes[100]);  // who has a slot changes
  }
  CHECK(hits > 100000);
  CHECK(cache.work().kept > 200);
  CHECK(cache.work().direct > 20);
  CHECK(cache.work().moved > 1000);
}

TEST_CASE("Where nothing leaves its fat box no pair is searched, and one body that moves costs its own pairs") {
  constexpr std::uint32_t kBodies = 1000;
  Random random(4);
  PairCache cache(kBodies, 64 * kBodies);
  Boxes boxes = heap(kBodies, random);
  for (int step = 0; step < 10; ++step) {
    for (auto& box : boxes) box = moved(box, random.vector(1e-4));
    (void)by_cache(cache, boxes);
  }
  CHECK(cache.work().rebuilt == 1);
  CHECK(cache.work().kept == 9);
  CHECK(cache.work().moved == 0);
  boxes[17] = moved(boxes[17], {1, 0, 0});
  CHECK(by_cache(cache, boxes) == by_brute_force(boxes));
  CHECK(cache.work().rebuilt == 1);
  CHECK(cache.work().moved == 1);
}

TEST_CASE("Kept pairs come in the order of their keys, so that a world need not sort them") {
  Random random(5);
  PairCache cache(200, 20000);
  Boxes boxes = heap(200, random);
  for (int step = 0; step < 20; ++step) {
    BoundedVector<physics::SlotPair> pairs(20000);
    REQUIRE(cache.find(boxes, pairs));
    for (std::uint32_t i = 0; i < pairs.size(); ++i) {
      REQUIRE(pairs[i].a < pairs[i].b);
      if (i > 0) REQUIRE(std::pair(pairs[i - 1].a, pairs[i - 1].b) < std::pair(pairs[i].a, pairs[i].b));
    }
    for (std::uint32_t i = 0; i < 10; ++i) boxes[i * 7] = moved(boxes[i * 7], random.vector(0.1));
  }
  CHECK(cache.work().kept == 19);
}

TEST_CASE("More pairs than the capacity: those that fit are found, and the overflow is reported") {
  Boxes boxes(40, Aabb{{0, 0, 0}, {1, 1, 1}});  // 780 pairs
  PairCache cache(40, 100);
  for (int step = 0; step < 20; ++step) {
    BoundedVector<physics::SlotPair> pairs(100);
    CHECK_FALSE(cache.find(boxes, pairs));
    CHECK(pairs.size() == 100);
  }
  // Spread out they fit, and are kept again.
  for (std::uint32_t i = 0; i < 40; ++i) boxes[i] = moved(boxes[i], {0.6 * i, 0, 0});
  for (int step = 0; step < 20; ++step) CHECK(by_cache(cache, boxes) == by_brute_force(boxes));
  CHECK(cache.work().kept > 0);
}

TEST_CASE("A box that is no number overlaps nothing, and hides no pair of the others") {
  Random random(6);
  PairCache cache(100, 5000);
  Boxes boxes = heap(100, random);
  for (int step = 0; step < 6; ++step) {
    if (step == 2) boxes[10].lower.x = std::numeric_limits<double>::quiet_NaN();
    if (step == 4) boxes[11].upper.z = std::numeric_limits<double>::infinity();
    CHECK(by_cache(cache, boxes) == by_brute_force(boxes));
  }
}
