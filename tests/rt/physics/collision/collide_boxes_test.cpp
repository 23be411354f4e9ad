// Several pairs of boxes at once give what each pair gives alone, bit by bit.
#include "rt/physics/collision/collide_boxes.h"

#include <bit>
#include <catch2/catch.hpp>
#include <limits>
#include <vector>

#include "tests/rt/physics/collision/collide_support.h"

using namespace tactus;
using namespace tactus::physics;
using namespace tactus::physics::support;

namespace {

struct BoxPair {
  Shape a, b;
  Posed pose_a, pose_b;
  ManifoldQuery query;
  AxisCache cache;
};

// Far apart, near, overlapping, at any angle or parallel, with and without the memory of a last step.
BoxPair random_boxes(Random& random) {
  BoxPair pair{random_shape(random, ShapeKind::kBox),
               random_shape(random, ShapeKind::kBox),
               random.pose(0.06),
               random.pose(0.06),
               {.margin = random(1e-4, 5e-3)},
               {}};
  if (random(0.0, 1.0) < 0.3) pair.pose_b.rotation = pair.pose_a.rotation;
  pair.cache.axis = static_cast<std::uint8_t>(random(0.0, 15.99));
  const Manifold last = touch(pair.a, pair.pose_a, pair.b, pair.pose_b, pair.query.margin);
  pair.query.last.count = last.count;
  for (std::uint32_t i = 0; i < last.count; ++i) pair.query.last.of[i] = last.points[i].feature;
  return pair;
}

bool same_bits(double x, double y) { return std::bit_cast<std::uint64_t>(x) == std::bit_cast<std::uint64_t>(y); }
bool same_bits(const Vec3d& v, const Vec3d& w) {
  return same_bits(v.x, w.x) && same_bits(v.y, w.y) && same_bits(v.z, w.z);
}

// Compares the manifolds of all pairs at once with those of each alone. Returns how many have points.
int require_same(std::vector<BoxPair> pairs) {
  std::array<Manifold, kBoxPairs> found;
  std::vector<BodyFrame> frames;
  std::vector<AxisCache> caches;
  for (const BoxPair& pair : pairs) {
    frames.push_back(BodyFrame::of(pair.pose_a));
    frames.push_back(BodyFrame::of(pair.pose_b));
    caches.push_back(pair.cache);
  }
  std::vector<BoxPairQuery> queries;
  for (std::size_t k = 0; k < pairs.size(); ++k)
    queries.push_back({{pairs[k].a, pairs[k].pose_a},
                       {pairs[k].b, pairs[k].pose_b},
                       frames[2 * k],
                       frames[2 * k + 1],
                       pairs[k].query,
                       caches[k],
                       found[k]});
  collide_boxes(queries);
  int touching = 0;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    BoxPair& pair = pairs[k];
    const Manifold alone = collide({pair.a, pair.pose_a}, {pair.b, pair.pose_b}, pair.query, pair.cache);
    REQUIRE(caches[k] == pair.cache);
    REQUIRE(found[k].count == alone.count);
    REQUIRE(same_bits(found[k].gap, alone.gap));
    REQUIRE(same_bits(found[k].lever_arm, alone.lever_arm));
    if (alone.count == 0) continue;
    ++touching;
    REQUIRE(same_bits(found[k].normal, alone.normal));
    for (std::uint32_t i = 0; i < alone.count; ++i) {
      REQUIRE(found[k].points[i].feature == alone.points[i].feature);
      REQUIRE(same_bits(found[k].points[i].separation, alone.points[i].separation));
      REQUIRE(same_bits(found[k].points[i].from_a, alone.points[i].from_a));
      REQUIRE(same_bits(found[k].points[i].from_b, alone.points[i].from_b));
    }
  }
  return touching;
}

}  // namespace

TEST_CASE("One to four pairs of boxes at once have the manifolds of each pair alone") {
  Random random(41);
  int touching = 0, pairs = 0;
  for (int n = 0; n < tries(500); ++n) {
    std::vector<BoxPair> group;
    for (int k = 0; k <= n % static_cast<int>(kBoxPairs); ++k) group.push_back(random_boxes(random));
    pairs += static_cast<int>(group.size());
    touching += require_same(group);
  }
  REQUIRE(touching > pairs / 4);
  REQUIRE(touching < pairs);
}

TEST_CASE("A pair of boxes with a pose that is not finite has no points and leaves those beside it unchanged") {
  Random random(42);
  std::vector<BoxPair> group;
  for (std::uint32_t k = 0; k < kBoxPairs; ++k) group.push_back(random_boxes(random));
  group[1].pose_b.position.y = std::numeric_limits<double>::quiet_NaN();
  group[2].pose_a.rotation.w = std::numeric_limits<double>::quiet_NaN();
  const std::vector<BoxPair> beside{group[0], group[3]};
  REQUIRE(require_same(group) == require_same(beside));
}
