// Properties of every pair of shapes, over seeded random pairs that nearly touch.
#include <catch2/catch.hpp>
#include <string>

#include "tests/rt/physics/collision/collide_support.h"

using namespace tactus;
using namespace tactus::physics;
using namespace tactus::physics::support;

namespace {

constexpr double kMargin = 5e-3;

struct Pair {
  Shape a, b;
  Posed pose_a, pose_b;
};

// B is moved along a random direction until it is about touching: halve the interval on the reference distance, then
// a random step in or out.
Pair random_pair(Random& random, ShapeKind kind_a, ShapeKind kind_b) {
  Pair pair{random_shape(random, kind_a), random_shape(random, kind_b), random.pose(0.5), random.pose(0.5)};
  const Vec3d direction =
      kind_b == ShapeKind::kPlane ? -rotate(pair.pose_b.rotation, Vec3d{0, 0, 1}) : random.direction();
  double near = 0, far = 1.0;
  const Vec3d start = pair.pose_a.position;
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (near + far);
    pair.pose_b.position = start + direction * middle;
    (reference_distance(pair.a, pair.pose_a, pair.b, pair.pose_b) > 0 ? far : near) = middle;
  }
  pair.pose_b.position = start + direction * (far + random(-kMargin, 2 * kMargin));
  return pair;
}

const std::pair<ShapeKind, ShapeKind> kKinds[] = {
    {ShapeKind::kSphere, ShapeKind::kSphere},   {ShapeKind::kSphere, ShapeKind::kCapsule},
    {ShapeKind::kSphere, ShapeKind::kBox},      {ShapeKind::kSphere, ShapeKind::kPlane},
    {ShapeKind::kCapsule, ShapeKind::kCapsule}, {ShapeKind::kCapsule, ShapeKind::kBox},
    {ShapeKind::kCapsule, ShapeKind::kPlane},   {ShapeKind::kBox, ShapeKind::kBox},
    {ShapeKind::kBox, ShapeKind::kPlane}};

Manifold touch(const Pair& p, double margin = kMargin) {
  return physics::support::touch(p.a, p.pose_a, p.b, p.pose_b, margin);
}

// Requires that at least 10 % of the pairs of each two kinds touch, so that a check on touching pairs is not empty.
template <class Check>
void for_random_pairs(std::uint32_t seed, int count, Check check) {
  for (const auto& [kind_a, kind_b] : kKinds) {
    Random random(seed);
    int touching = 0;
    for (int n = 0; n < tries(count); ++n) {
      const Pair pair = random_pair(random, kind_a, kind_b);
      INFO("kinds " << int(kind_a) << " " << int(kind_b) << ", pair " << n);
      touching += touch(pair).count > 0 ? 1 : 0;
      check(pair, random);
    }
    INFO("kinds " << int(kind_a) << " " << int(kind_b));
    REQUIRE(10 * touching >= tries(count));
  }
}

double gap(const Pair& p) { return reference_distance(p.a, p.pose_a, p.b, p.pose_b); }

// Boxes of which one ends so near to a plane of the other's face that it may pass over it (manifold.h).
bool may_pass_over(const Pair& p) {
  if (p.a.kind != ShapeKind::kBox || p.b.kind != ShapeKind::kBox) return false;
  const auto reach = [](const Shape& box, const Posed& pose, const Vec3d& n) {
    const Vec3d in_box = rotate_inverse(pose.rotation, n);
    return std::abs(in_box.x) * box.half_extents.x + std::abs(in_box.y) * box.half_extents.y +
           std::abs(in_box.z) * box.half_extents.z;
  };
  for (const Posed* pose : {&p.pose_a, &p.pose_b}) {
    for (const Vec3d& axis : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}) {
      const Vec3d n = rotate(pose->rotation, axis);
      const double separation =
          std::abs(dot(n, p.pose_b.position - p.pose_a.position)) - reach(p.a, p.pose_a, n) - reach(p.b, p.pose_b, n);
      if (std::abs(separation) <= 1e-4) return true;
    }
  }
  return false;
}

double largest(const Vec3d& v) { return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)}); }

}  // namespace

TEST_CASE("A contact is found just where the shapes are within the margin, and its gap is never overstated") {
  for_random_pairs(1, 600, [](const Pair& p, Random&) {
    const double truth = gap(p);
    const Manifold m = touch(p);
    if (truth <= kMargin - 1e-9 && !(truth > 1e-5 && may_pass_over(p))) REQUIRE(m.count >= 1);
    if (m.count == 0) return;
    const double reported = least_separation(m);
    REQUIRE(reported <= truth + 1e-9);
    const bool boxes = p.a.kind == ShapeKind::kBox && p.b.kind == ShapeKind::kBox;
    if (boxes) {  // the best of 15 axes bounds the distance from below
      if (truth > 0) REQUIRE(reported >= 0.0);
    } else if (p.b.kind == ShapeKind::kBox) {  // exact outside; inside, the reference stops at the skeleton
      if (truth > -(p.a.radius + p.b.radius) + 1e-9) REQUIRE(reported == Approx(truth).margin(1e-9));
    } else {
      REQUIRE(reported == Approx(truth).margin(1e-9));
    }
  });
}

TEST_CASE("Every manifold has at most four distinct points within the margin and a unit normal from A to B") {
  for_random_pairs(2, 600, [](const Pair& p, Random&) {
    const Manifold m = touch(p);
    REQUIRE(m.count <= 4);
    if (m.count == 0) return;
    REQUIRE(norm(m.normal) == Approx(1.0).margin(1e-12));
    for (std::uint32_t i = 0; i < m.count; ++i) {
      REQUIRE(m.points[i].separation <= kMargin);
      for (std::uint32_t j = 0; j < i; ++j) REQUIRE(m.points[i].feature != m.points[j].feature);
    }
    // Away along the normal the gap grows by what B moved.
    Pair apart = p;
    apart.pose_b.position += m.normal * 0.3;
    if (p.b.kind != ShapeKind::kPlane)
      REQUIRE(gap(apart) > gap(p));
    else
      REQUIRE(gap(apart) == Approx(gap(p) + 0.3).margin(1e-9));
  });
}

TEST_CASE("Both bodies name the same contact point") {
  for_random_pairs(3, 300, [](const Pair& p, Random&) {
    const Manifold m = touch(p);
    for (std::uint32_t i = 0; i < m.count; ++i)
      REQUIRE(largest(p.pose_a.position + m.points[i].from_a - p.pose_b.position - m.points[i].from_b) < 1e-12);
  });
}

TEST_CASE("A manifold moves with its bodies") {
  for_random_pairs(4, 400, [](const Pair& p, Random& random) {
    const Posed moved = random.pose(2.0);
    const Manifold m = touch(p), n = touch({p.a, p.b, moved * p.pose_a, moved * p.pose_b});
    REQUIRE(m.count == n.count);
    if (m.count == 0) return;
    REQUIRE(largest(rotate(moved.rotation, m.normal) - n.normal) < 1e-9);
    for (std::uint32_t i = 0; i < m.count; ++i) {
      REQUIRE(m.points[i].feature == n.points[i].feature);
      REQUIRE(m.points[i].separation == Approx(n.points[i].separation).margin(1e-9));
      REQUIRE(largest(rotate(moved.rotation, m.points[i].from_a) - n.points[i].from_a) < 1e-9);
    }
  });
}

TEST_CASE("A kilometre from the origin the separation is the same to a nanometre") {
  for_random_pairs(5, 400, [](const Pair& p, Random&) {
    const Vec3d far{1000, -700, 300};
    Pair q = p;
    q.pose_a.position += far;
    q.pose_b.position += far;
    const Manifold m = touch(p), n = touch(q);
    REQUIRE(m.count == n.count);
    for (std::uint32_t i = 0; i < m.count; ++i)
      REQUIRE(m.points[i].separation == Approx(n.points[i].separation).margin(1e-9));
  });
}

TEST_CASE("The pair in the other order gives the mirrored manifold") {
  for_random_pairs(6, 600, [](const Pair& p, Random&) {
    const Manifold m = touch(p), n = touch({p.b, p.a, p.pose_b, p.pose_a});
    const bool boxes = p.a.kind == ShapeKind::kBox && p.b.kind == ShapeKind::kBox;
    if (boxes) {  // which face is the reference may differ where two are about equally good
      if (gap(p) <= kMargin - 1e-9 && !(gap(p) > 1e-5 && may_pass_over(p))) REQUIRE((m.count > 0 && n.count > 0));
      return;
    }
    REQUIRE(m.count == n.count);
    if (m.count == 0) return;
    REQUIRE(largest(m.normal + n.normal) < 1e-9);
    REQUIRE(least_separation(m) == Approx(least_separation(n)).margin(1e-9));
  });
}

TEST_CASE("Deep overlap, equal centres and extreme sizes give finite unit normals") {
  Random random(7);
  const ShapeKind kinds[] = {ShapeKind::kSphere, ShapeKind::kCapsule, ShapeKind::kBox, ShapeKind::kPlane};
  const auto extreme = [&](ShapeKind kind) {
    const auto size = [&] { return random.below(8) == 0 ? 0.0 : random.log_uniform(1e-4, 5.0); };
    switch (kind) {
      case ShapeKind::kSphere:
        return Shape::sphere(size());
      case ShapeKind::kCapsule:
        return Shape::capsule(size(), size());
      case ShapeKind::kBox:
        return Shape::box({size(), size(), size()});
      case ShapeKind::kPlane:
      case ShapeKind::kHull:
      case ShapeKind::kCompound:
      case ShapeKind::kCylinder:
      case ShapeKind::kCone:
      case ShapeKind::kMesh:
        break;
    }
    return Shape::plane();
  };
  int found = 0;
  for (int n = 0; n < 40000; ++n) {
    const Shape a = extreme(kinds[random.below(4)]), b = extreme(kinds[random.below(4)]);
    Posed pose_a{{}, random.below(2) == 0 ? Quatd{} : random.rotation()}, pose_b = pose_a;
    if (random.below(2) == 0) pose_b.rotation = random.rotation();
    if (random.below(2) == 0) pose_b.position = random.vector(random.log_uniform(1e-14, 1.0));
    const Manifold m = touch({a, b, pose_a, pose_b}, 1e-3);
    REQUIRE(m.count <= 4);
    if (a.kind != ShapeKind::kPlane || b.kind != ShapeKind::kPlane)
      if (pose_b.position == Vec3d{}) REQUIRE(m.count > 0);
    if (m.count == 0) continue;
    ++found;
    REQUIRE(std::abs(norm(m.normal) - 1.0) < 1e-9);
    for (std::uint32_t i = 0; i < m.count; ++i) {
      REQUIRE(is_finite(m.points[i].from_a));
      REQUIRE(is_finite(m.points[i].from_b));
      REQUIRE(std::isfinite(m.points[i].separation));
    }
  }
  REQUIRE(found > 20000);
}

TEST_CASE("A pose that is not finite touches nothing") {
  const double nan = std::nan("");
  for (const auto& [kind_a, kind_b] : kKinds) {
    Random random(8);
    Pair p = random_pair(random, kind_a, kind_b);
    p.pose_b.position.x = nan;
    p.pose_b.position.y = nan;
    p.pose_b.position.z = nan;
    REQUIRE(touch(p).count == 0);
  }
}
