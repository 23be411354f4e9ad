#include "sim/broad_phase/pair_grid.h"

#include <catch2/catch.hpp>
#include <limits>
#include <random>

#include "tests/sim/broad_phase/pair_support.h"

namespace {

using namespace tactus;
using namespace tactus::test;

struct Found {
  Keys keys;  // sorted, the lower body first
  sim::PairGrid::Work work;
};

Found by_grid(const Boxes& boxes) {
  sim::PairGrid grid(static_cast<std::uint32_t>(boxes.size()));
  auto pairs = list_for_pairs(boxes);
  REQUIRE(grid.find(boxes, pairs));
  return {sorted_keys(pairs), grid.work()};
}

class BoxMaker {
 public:
  explicit BoxMaker(unsigned seed) : random_(seed) {}
  double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vec3d point(double half) { return {uniform(-half, half), uniform(-half, half), uniform(-half, half)}; }
  physics::Aabb box(const Vec3d& centre, double size) {
    const Vec3d half{size * uniform(0.1, 0.5), size * uniform(0.1, 0.5), size * uniform(0.1, 0.5)};
    return {centre - half, centre + half};
  }

 private:
  std::mt19937 random_;
};

// A cube of n^3 boxes of 0.1 m that touch their neighbours within a slack.
Boxes lattice(unsigned n) {
  Boxes boxes;
  for (unsigned x = 0; x < n; ++x)
    for (unsigned y = 0; y < n; ++y)
      for (unsigned z = 0; z < n; ++z) {
        const Vec3d centre{0.1 * x, 0.1 * y, 0.1 * z}, half{0.051, 0.051, 0.051};
        boxes.push_back({centre - half, centre + half});
      }
  return boxes;
}

}  // namespace

TEST_CASE("The grid finds exactly the pairs of the brute-force test") {
  const unsigned seed = GENERATE(range(0u, 40u));
  BoxMaker make(seed);
  Boxes boxes;
  SECTION("sizes from 1 to 100") {
    for (int i = 0; i < 300; ++i) {
      const double size = 0.01 * std::pow(100.0, make.uniform(0, 1));
      boxes.push_back(make.box(make.point(1.0), size));
    }
  }
  SECTION("equal cubes") {
    for (int i = 0; i < 300; ++i) {
      const Vec3d centre = make.point(0.4), half{0.05, 0.05, 0.05};
      boxes.push_back({centre - half, centre + half});
    }
  }
  SECTION("clusters") {
    for (int cluster = 0; cluster < 5; ++cluster) {
      const Vec3d middle = make.point(10.0);
      for (int i = 0; i < 60; ++i) boxes.push_back(make.box(middle + make.point(0.1), 0.08));
    }
  }
  SECTION("a million metres from the origin") {
    for (int i = 0; i < 300; ++i)
      boxes.push_back(make.box(Vec3d{1e6, -1e6, 1e6} + make.point(0.5), make.uniform(0, 1) < 0.1 ? 0.6 : 0.1));
  }
  SECTION("beyond the last cell") {
    for (int i = 0; i < 100; ++i) boxes.push_back(make.box(Vec3d{1e13, 0, -1e13} + make.point(0.5), 0.3));
    for (int i = 0; i < 100; ++i) boxes.push_back(make.box(make.point(0.5), 0.3));
  }
  SECTION("on cell boundaries") {
    // Multiples of a half in every coordinate: many boxes touch without overlapping in depth, which counts.
    for (int i = 0; i < 200; ++i) {
      const Vec3d p = make.point(6);
      const Vec3d lower{0.5 * std::floor(p.x), 0.5 * std::floor(p.y), 0.5 * std::floor(p.z)};
      boxes.push_back({lower, lower + Vec3d{0.5, 0.5, 0.5}});
    }
  }
  SECTION("points and one box around all") {
    for (int i = 0; i < 100; ++i) {
      const Vec3d p = make.point(0.5);
      boxes.push_back({p, p});
      boxes.push_back(make.box(p, 0.05));
    }
    boxes.push_back({{-1e30, -1e30, -1e30}, {1e30, 1e30, 1e30}});
    const double all = std::numeric_limits<double>::infinity();
    boxes.push_back({{-all, -all, -all}, {all, all, all}});
  }
  const Keys expected = by_brute_force(boxes);
  REQUIRE(by_grid(boxes).keys == expected);
}

TEST_CASE("Boxes that are not a number overlap nothing and disturb nothing") {
  BoxMaker make(7);
  Boxes boxes;
  for (int i = 0; i < 100; ++i) boxes.push_back(make.box(make.point(0.5), 0.3));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  boxes[13] = {{nan, nan, nan}, {nan, nan, nan}};
  boxes[50].lower.y = nan;
  const Keys expected = by_brute_force(boxes);
  CHECK(by_grid(boxes).keys == expected);
  CHECK(expected.size() > 50);
}

TEST_CASE("Few boxes are no special case") {
  CHECK(by_grid({}).keys.empty());
  CHECK(by_grid({{{0, 0, 0}, {1, 1, 1}}}).keys.empty());
  CHECK(by_grid({{{0, 0, 0}, {1, 1, 1}}, {{1, 1, 1}, {2, 2, 2}}}).keys == Keys{{0, 1}});
}

TEST_CASE("Work grows with the bodies, not with their square") {
  // In a lattice a box meets its 26 neighbours, so that pairs grow as bodies do; work may exceed them by a factor that
  // does not grow. 8 times the bodies: brute force would do 64 times the tests.
  const Found small = by_grid(lattice(8)), large = by_grid(lattice(16));
  CHECK(large.keys.size() > 8 * small.keys.size());
  const double growth = static_cast<double>(large.work.box_tests + large.work.rows) /
                        static_cast<double>(small.work.box_tests + small.work.rows);
  CHECK(growth < 12);
  CHECK(large.work.rows <= 5u * 16 * 16 * 16);
  CHECK(large.work.box_tests < 40u * 16 * 16 * 16);
}

TEST_CASE("One large box among many small ones costs each of them a few rows") {
  Boxes boxes = lattice(12);
  const Found without = by_grid(boxes);
  boxes.push_back({{-5, -5, -5}, {5, 5, 5}});
  const Found with = by_grid(boxes);
  CHECK(with.keys.size() == without.keys.size() + boxes.size() - 1);
  CHECK(with.work.rows <= without.work.rows + 9 * boxes.size() + 5);
}

TEST_CASE("Pairs come in the same order every time, and a full vector is reported") {
  const Boxes boxes = lattice(5);
  const auto count = static_cast<std::uint32_t>(by_brute_force(boxes).size());
  sim::PairGrid grid(125);
  BoundedVector<physics::SlotPair> first(count), again(count), too_small(count - 1);
  REQUIRE(grid.find(boxes, first));
  REQUIRE(grid.find(boxes, again));
  for (std::uint32_t i = 0; i < count; ++i) {
    CHECK(first[i].a == again[i].a);
    CHECK(first[i].b == again[i].b);
  }
  CHECK_FALSE(grid.find(boxes, too_small));
  CHECK(too_small.full());
}

// The last range first: an order in which no single thread would come by itself.
TEST_CASE("Found in parts, the pairs, their order, the work and what is left out are those found at once") {
  const auto backwards = [](void*, std::uint32_t count, std::uint32_t, physics::Executor::Work work,
                            void* context) noexcept {
    for (std::uint32_t k = count; k-- > 0;) work(context, k, k + 1);
  };
  const Boxes boxes = lattice(7);
  const auto bodies = static_cast<std::uint32_t>(boxes.size());
  const std::uint32_t room = GENERATE(0u, 1u, 57u, 500u, 100'000u);
  const std::uint32_t parts = GENERATE(2u, 3u, 8u);
  sim::PairGrid grid(bodies), shared(bodies);
  shared.share_work({backwards, nullptr}, parts, room);
  BoundedVector<physics::SlotPair> at_once(room), in_parts(room);
  CHECK(grid.find(boxes, at_once) == shared.find(boxes, in_parts));
  const auto same = [](const physics::SlotPair& p, const physics::SlotPair& q) { return p.a == q.a && p.b == q.b; };
  CHECK(std::equal(at_once.begin(), at_once.end(), in_parts.begin(), in_parts.end(), same));
  if (room == 100'000) {
    REQUIRE(at_once.size() > 500);
    CHECK(shared.work().box_tests == grid.work().box_tests);
    CHECK(shared.work().rows == grid.work().rows);
  }
}
