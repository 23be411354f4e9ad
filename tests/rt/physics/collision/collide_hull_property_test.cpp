// Properties of every pair with a hull, over seeded random pairs that nearly touch.
#include <catch2/catch.hpp>

#include "tests/rt/physics/shapes/hull_support.h"

using namespace tactus;
using namespace tactus::physics;
using namespace tactus::physics::support;

namespace {

constexpr double kMargin = 5e-3;

struct Pair {
  Shape a, b;
  Posed pose_a, pose_b;
  std::vector<Hull> hulls;
};

double gap(const Pair& p) {
  const Solid b = solid_of(p.b, p.pose_b, p.hulls);
  switch (p.a.kind) {
    case ShapeKind::kSphere:
      return distance(p.pose_a.position, b) - p.a.radius;
    case ShapeKind::kCapsule:
      return distance(axis_of(p.a, p.pose_a), b) - p.a.radius;
    case ShapeKind::kPlane: {
      double lowest = 1e300;
      for (const Vec3d& v : b.vertices) lowest = std::min(lowest, (inverse(p.pose_a) * v).z);
      return lowest;
    }
    default:
      return distance(solid_of(p.a, p.pose_a, p.hulls), b);
  }
}

std::uint32_t random_count(Random& random) {
  const std::uint32_t counts[] = {4, 6, 8, 12, 20};
  return counts[random.below(5)];
}

TestHull any_hull(Random& random) {
  switch (random.below(4)) {
    case 0:
      return prism_hull(3 + random.below(12), random(0.02, 0.1), random(0.01, 0.1));
    case 1:
      return box_hull({random(0.01, 0.1), random(0.01, 0.1), random(0.01, 0.1)});
    default:
      return random_hull(random, random_count(random), 0.1);
  }
}

// B is moved along a random direction until it is about touching, then a random step in or out.
Pair random_pair(Random& random, ShapeKind kind_a) {
  Pair pair;
  pair.hulls.push_back(any_hull(random).hull);
  pair.hulls.push_back(any_hull(random).hull);
  pair.a = kind_a == ShapeKind::kHull ? Shape::convex(pair.hulls[0], 0) : random_shape(random, kind_a);
  pair.b = Shape::convex(pair.hulls[1], 1);
  pair.pose_a = random.pose(0.5);
  pair.pose_b = random.pose(0.5);
  const Vec3d direction =
      kind_a == ShapeKind::kPlane ? rotate(pair.pose_a.rotation, Vec3d{0, 0, 1}) : random.direction();
  double near = 0, far = 1.0;
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (near + far);
    pair.pose_b.position = pair.pose_a.position + direction * middle;
    (gap(pair) > 0 ? far : near) = middle;
  }
  pair.pose_b.position = pair.pose_a.position + direction * (far + random(-kMargin, 2 * kMargin));
  return pair;
}

Manifold touch(const Pair& p, AxisCache cache = {}) {
  return collide({p.a, p.pose_a}, {p.b, p.pose_b}, {.margin = kMargin}, cache, p.hulls);
}

// Requires that at least 10 % of the pairs of each kind touch, so that a check on touching pairs is not empty.
template <class Check>
void for_random_pairs(std::uint32_t seed, int count, Check check) {
  using enum ShapeKind;
  for (const ShapeKind kind : {kSphere, kCapsule, kBox, kPlane, kHull}) {
    Random random(seed);
    int touching = 0;
    for (int n = 0; n < tries(count); ++n) {
      const Pair pair = random_pair(random, kind);
      INFO("kind " << int(kind) << ", pair " << n);
      touching += touch(pair).count > 0 ? 1 : 0;
      check(pair, random);
    }
    INFO("kind " << int(kind));
    REQUIRE(10 * touching >= tries(count));
  }
}

double largest(const Vec3d& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

double preference(double separation) { return 0.05 * std::abs(separation) + 1e-5; }

bool two_solids(const Pair& p) { return p.a.kind == ShapeKind::kBox || p.a.kind == ShapeKind::kHull; }

}  // namespace

TEST_CASE("A contact with a hull is found just where it is within the margin, and its gap is never overstated") {
  for_random_pairs(1, 300, [](const Pair& p, Random&) {
    const double truth = gap(p);
    const Manifold m = touch(p);
    if (truth <= kMargin - 1e-9) REQUIRE(m.count >= 1);
    if (m.count == 0) return;
    const double reported = least_separation(m);
    REQUIRE(reported <= truth + 1e-9);
    if (two_solids(p)) {
      if (truth > 0) REQUIRE(reported >= 0.0);
    } else if (p.a.kind == ShapeKind::kPlane || truth > -p.a.radius + 1e-9) {
      REQUIRE(reported == Approx(truth).margin(1e-9));
    }
  });
}

TEST_CASE("Where hulls overlap the depth is that of the best of all axes, within the preference") {
  Random random(2);
  int overlaps = 0;
  for (int n = 0; n < 150; ++n) {
    Pair p = random_pair(random, n % 2 == 0 ? ShapeKind::kHull : ShapeKind::kBox);
    p.pose_b.position += (p.pose_a.position - p.pose_b.position) * random(0, 0.2);
    const Solid a = solid_of(p.a, p.pose_a, p.hulls), b = solid_of(p.b, p.pose_b, p.hulls);
    const double best = best_gap(a, b);
    if (best >= 0) continue;
    ++overlaps;
    INFO("pair " << n << ", best " << best);
    const Manifold m = touch(p);
    REQUIRE(m.count >= 1);
    // The axis is about the best (a face may be twice as deep as edges along it), and no point is deeper than its axis
    // says.
    const double along = gap_along(a, b, m.normal);
    REQUIRE(along <= best + 1e-9);
    REQUIRE(along >= 2 * best - 2.3e-4);
    REQUIRE(least_separation(m) >= along - 1e-9);
    REQUIRE(least_separation(m) <= 1e-5);
  }
  REQUIRE(overlaps > 60);
}

TEST_CASE("Every manifold with a hull has at most four distinct points within the margin and a unit normal") {
  for_random_pairs(3, 150, [](const Pair& p, Random&) {
    const Manifold m = touch(p);
    REQUIRE(m.count <= 4);
    if (m.count == 0) return;
    REQUIRE(norm(m.normal) == Approx(1.0).margin(1e-12));
    for (std::uint32_t i = 0; i < m.count; ++i) {
      REQUIRE(m.points[i].separation <= kMargin);
      REQUIRE(largest(p.pose_a.position + m.points[i].from_a - p.pose_b.position - m.points[i].from_b) < 1e-12);
      for (std::uint32_t j = 0; j < i; ++j) REQUIRE(m.points[i].feature != m.points[j].feature);
    }
    Pair apart = p;
    apart.pose_b.position += m.normal * 0.3;
    REQUIRE(gap(apart) > gap(p));
  });
}

TEST_CASE("Contact points of overlapping hulls lie between their surfaces") {
  Random random(4);
  for (int n = 0; n < tries(200); ++n) {
    const Pair p = random_pair(random, n % 2 == 0 ? ShapeKind::kHull : ShapeKind::kBox);
    const Manifold m = touch(p);
    const Solid a = solid_of(p.a, p.pose_a, p.hulls), b = solid_of(p.b, p.pose_b, p.hulls);
    for (std::uint32_t i = 0; i < m.count; ++i) {
      const Vec3d point = p.pose_a.position + m.points[i].from_a;
      const double off = 0.5 * std::max(std::abs(m.points[i].separation), gap(p)) + 3e-5 + preference(kMargin);
      INFO("pair " << n << ", point " << i << ", separation " << m.points[i].separation);
      REQUIRE(distance(point, a) <= off);
      REQUIRE(distance(point, b) <= off);
    }
  }
}

TEST_CASE("A manifold with a hull moves with its bodies") {
  for_random_pairs(5, 150, [](const Pair& p, Random& random) {
    const Posed moved = random.pose(2.0);
    Pair q = p;
    q.pose_a = moved * p.pose_a;
    q.pose_b = moved * p.pose_b;
    const Manifold m = touch(p), n = touch(q);
    REQUIRE(m.count == n.count);
    if (m.count == 0) return;
    REQUIRE(largest(rotate(moved.rotation, m.normal) - n.normal) < 1e-9);
    for (std::uint32_t i = 0; i < m.count; ++i) {
      REQUIRE(m.points[i].feature == n.points[i].feature);
      REQUIRE(m.points[i].separation == Approx(n.points[i].separation).margin(1e-9));
    }
  });
}

TEST_CASE("The pair with the hull first gives the mirrored manifold") {
  for_random_pairs(6, 150, [](const Pair& p, Random&) {
    Pair q = p;
    std::swap(q.a, q.b);
    std::swap(q.pose_a, q.pose_b);
    const Manifold m = touch(p), n = touch(q);
    if (p.a.kind == ShapeKind::kHull) {  // which face is the reference may differ
      if (gap(p) <= kMargin - 1e-9) REQUIRE((m.count > 0 && n.count > 0));
      return;
    }
    REQUIRE(m.count == n.count);
    if (m.count == 0) return;
    REQUIRE(largest(m.normal + n.normal) < 1e-12);
    REQUIRE(least_separation(m) == Approx(least_separation(n)).margin(1e-12));
  });
}

TEST_CASE("A box given as a hull meets another as deep as the box does") {
  Random random(7);
  int overlaps = 0;
  for (int n = 0; n < 400; ++n) {
    const Vec3d half_a = random.vector(0.1), half_b = random.vector(0.1);
    const Shape a = Shape::box(abs(half_a) + Vec3d{0.005, 0.005, 0.005}),
                b = Shape::box(abs(half_b) + Vec3d{0.005, 0.005, 0.005});
    const std::vector<Hull> hulls{box_hull(a.half_extents).hull, box_hull(b.half_extents).hull};
    const Posed pose_a = random.pose(0.1), pose_b = random.pose(0.1);
    const auto as_boxes = touch({a, b, pose_a, pose_b, hulls});
    const auto as_hulls = touch({Shape::convex(hulls[0], 0), Shape::convex(hulls[1], 1), pose_a, pose_b, hulls});
    INFO("pair " << n);
    if (as_boxes.count == 0 || as_hulls.count == 0) continue;
    const PosedBox box_a{a.half_extents, pose_a}, box_b{b.half_extents, pose_b};
    if (distance(box_a, box_b) > 0) continue;
    ++overlaps;
    const Solid solid_a = solid_of(a, pose_a, hulls), solid_b = solid_of(b, pose_b, hulls);
    const double along_boxes = gap_along(solid_a, solid_b, as_boxes.normal),
                 along_hulls = gap_along(solid_a, solid_b, as_hulls.normal);
    // Within 8 degrees of a face's normal, an axis of two edges is chosen over it at ten times the preference alone.
    const double preferred = dot(as_boxes.normal, as_hulls.normal) > 0.99 ? 10.0 : 1.0;
    REQUIRE(along_hulls == Approx(along_boxes).margin(1.2 * preferred * preference(along_boxes)));
  }
  REQUIRE(overlaps > 100);
}

TEST_CASE("Noise below the solver's slop does not change what a manifold is made of") {
  int tested = 0;
  for_random_pairs(8, 100, [&tested](const Pair& p, Random& random) {
    AxisCache cache;
    const auto first = collide({p.a, p.pose_a}, {p.b, p.pose_b}, {.margin = kMargin}, cache, p.hulls);
    if (first.count == 0 || first.points[0].separation > 4.9e-3 || gap(p) > 0) return;
    ++tested;
    int changed = 0;
    for (int n = 0; n < 10; ++n) {
      Posed a = p.pose_a;
      a.position += random.vector(1e-8);
      const auto m = collide({p.a, a}, {p.b, p.pose_b}, {.margin = kMargin}, cache, p.hulls);
      if (m.count != first.count || norm(m.normal - first.normal) > 1e-3) ++changed;
    }
    REQUIRE(changed == 0);
  });
  CHECK(tested >= tries(20));
}

TEST_CASE("The axis of the last step saves work and changes no gap by more than the preference") {
  for_random_pairs(9, 100, [](const Pair& p, Random& random) {
    AxisCache any{static_cast<std::uint8_t>(random.below(256)), static_cast<std::uint8_t>(random.below(256)),
                  static_cast<std::uint8_t>(random.below(256))};
    const Manifold cold = touch(p), odd = touch(p, any);
    REQUIRE((cold.count == 0) == (odd.count == 0));
    if (cold.count == 0) return;
    const double gap_cold = least_separation(cold), gap_odd = least_separation(odd);
    if (gap(p) > 0) REQUIRE(gap_odd == Approx(gap_cold).margin(2.2 * preference(gap_cold)));
  });
}

TEST_CASE("The face that separated two hulls is tested first, and whatever it was changes no point") {
  std::uint32_t known = 0;
  for_random_pairs(11, 200, [&](const Pair& p, Random& random) {
    AxisCache cache;
    Pair apart = p;  // as in the step before
    apart.pose_b.position +=
        3 * kMargin * (p.pose_b.position - p.pose_a.position) * (1.0 / norm(p.pose_b.position - p.pose_a.position));
    const Manifold before = touch(apart), cold = touch(p);
    known += before.apart.axis != 0 ? 1 : 0;
    const AxisCache any{static_cast<std::uint8_t>(16 + random.below(2)), static_cast<std::uint8_t>(random.below(256)),
                        static_cast<std::uint8_t>(random.below(256))};
    for (const AxisCache& last : {before.apart, any}) {
      const Manifold warm =
          collide({p.a, p.pose_a}, {p.b, p.pose_b}, {.margin = kMargin, .apart = last}, cache = {}, p.hulls);
      REQUIRE(warm.count == cold.count);
      for (std::uint32_t i = 0; i < cold.count; ++i) {
        REQUIRE(warm.points[i].separation == cold.points[i].separation);
        REQUIRE(warm.points[i].feature == cold.points[i].feature);
      }
      if (warm.count == 0 && gap(p) > 0) REQUIRE(warm.gap <= gap(p) + 1e-12);
    }
  });
  CHECK(known > 0);
}

TEST_CASE("A hull that is not in the list, and a pose that is not finite, touch nothing") {
  for_random_pairs(10, 200, [](const Pair& p, Random&) {
    Pair q = p;
    q.hulls.pop_back();
    REQUIRE(touch(q).count == 0);
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
      q = p;
      q.pose_b.position.y = bad;
      REQUIRE(touch(q).count == 0);
      q = p;
      q.pose_b.rotation.x = bad;
      REQUIRE(touch(q).count == 0);
    }
  });
}
