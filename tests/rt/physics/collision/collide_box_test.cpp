// Two boxes: configurations with known points, and manifolds that must not flicker (cards, stacks).
#include <catch2/catch.hpp>
#include <set>

#include "tests/rt/physics/collision/collide_support.h"
#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using namespace tactus::physics::support;

namespace {

constexpr double kPi = 3.14159265358979323846;

std::set<std::uint32_t> touching_features(const Manifold& m, double within) {
  std::set<std::uint32_t> result;
  for (std::uint32_t i = 0; i < m.count; ++i)
    if (m.points[i].separation <= within) result.insert(m.points[i].feature);
  return result;
}

bool has_point(const Manifold& m, const Vec3d& from_a) {
  for (std::uint32_t i = 0; i < m.count; ++i)
    if (norm(m.points[i].from_a - from_a) < 1e-9) return true;
  return false;
}

Posed shaken(Random& random, const Posed& pose, double by_m, double by_rad) {
  return {pose.position + random.vector(by_m), quat_from_rotation_vector(random.vector(by_rad)) * pose.rotation};
}

// The points that carry the load keep their names, and the normal stays, while both bodies tremble by a micrometre.
// Gives the normal.
Vec3d require_steady(const Shape& a, const Posed& pose_a, const Shape& b, const Posed& pose_b,
                     std::size_t expected_points, double least_cosine = 1 - 1e-9) {
  Random random(11);
  AxisCache cache;
  const auto first = collide({a, pose_a}, {b, pose_b}, {.margin = 5e-4}, cache);
  const auto names = touching_features(first, 5e-5);
  REQUIRE(names.size() == expected_points);
  for (int step = 0; step < 2000; ++step) {
    const Posed shaken_a = shaken(random, pose_a, 1e-6, 2e-6), shaken_b = shaken(random, pose_b, 1e-6, 2e-6);
    const auto m = collide({a, shaken_a}, {b, shaken_b}, {.margin = 5e-4}, cache);
    REQUIRE(touching_features(m, 5e-5) == names);
    REQUIRE(dot(m.normal, first.normal) > least_cosine);
  }
  return first.normal;
}

const Shape kCube = Shape::box({0.1, 0.1, 0.1});
const Shape kCard = Shape::box({0.05, 0.03, 0.00015});  // 100 x 60 x 0.3 mm

}  // namespace

TEST_CASE("A small box on a large one rests on its four lower corners") {
  const auto large = Shape::box({1, 1, 0.1}), small = Shape::box({0.1, 0.2, 0.3});
  const auto m = touch(large, {{3, 4, 5}, {}}, small, {{3.2, 3.8, 5.401}, {}}, 0.002);
  REQUIRE(m.count == 4);
  REQUIRE(m.normal == Vec3d{0, 0, 1});
  for (const double x : {0.1, 0.3})
    for (const double y : {-0.4, 0.0}) REQUIRE(has_point(m, {x, y, 0.1005}));
  for (std::uint32_t i = 0; i < 4; ++i) REQUIRE(m.points[i].separation == Approx(0.001).margin(1e-12));
}

TEST_CASE("Boxes that overhang rest on the corners of their common rectangle") {
  const auto m = touch(kCube, {}, kCube, {{0.15, 0.04, 0.199}, {}}, 0.002);
  REQUIRE(m.count == 4);
  for (const double x : {0.05, 0.1})
    for (const double y : {-0.06, 0.1}) REQUIRE(has_point(m, {x, y, 0.0995}));
  for (std::uint32_t i = 0; i < 4; ++i) REQUIRE(m.points[i].separation == Approx(-0.001).margin(1e-12));
}

TEST_CASE("Each face of a box can be touched") {
  Random random(4);
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) {
      const auto a = Shape::box({0.1, 0.2, 0.3}), b = Shape::box({0.05, 0.06, 0.07});
      Posed pose_b{random.vector(0.04), {}};
      pose_b.position[axis] = sign * (a.half_extents[axis] + b.half_extents[axis] + 1e-3);
      const Posed world = random.pose(1.0);
      const auto m = touch(a, world, b, world * pose_b, 2e-3);
      Vec3d n;
      n[axis] = sign;
      REQUIRE(m.count == 4);
      REQUIRE(norm(m.normal - rotate(world.rotation, n)) < 1e-12);
      REQUIRE(least_separation(m) == Approx(1e-3).margin(1e-12));
    }
}

TEST_CASE("A cube turned by an eighth on a cube rests on four corners of the octagon that carry the most") {
  const auto m = touch(kCube, {}, kCube, {{0, 0, 0.2}, turn({0, 0, 1}, kPi / 4)}, 1e-3);
  REQUIRE(m.count == 4);
  // The octagon's corners lie at distance 0.1 / cos(22.5 degrees); any four spread by the rule hold the centre.
  Vec3d sum;
  for (std::uint32_t i = 0; i < 4; ++i) {
    REQUIRE(norm(Vec3d{m.points[i].from_a.x, m.points[i].from_a.y, 0}) == Approx(0.1 / std::cos(kPi / 8)));
    sum += m.points[i].from_a;
  }
  REQUIRE(norm(Vec3d{sum.x, sum.y, 0}) < 0.1);
  require_steady(kCube, {}, kCube, {{0, 0, 0.2}, turn({0, 0, 1}, kPi / 4)}, 4);
}

TEST_CASE("Crossing edges touch in one point with the gap between the edges") {
  // Both cubes stand on an edge: A's upper edge along x, B's lower edge along y.
  const double reach = 0.1 * std::sqrt(2.0);
  const Quatd a = turn({1, 0, 0}, kPi / 4), b = turn({0, 1, 0}, kPi / 4);
  for (const double gap : {-0.001, 0.001}) {
    const auto m = touch(kCube, {{0, 0, 0}, a}, kCube, {{0.03, 0.02, 2 * reach + gap}, b}, 0.002);
    REQUIRE(m.count == 1);
    REQUIRE(norm(m.normal - Vec3d{0, 0, 1}) < 1e-12);
    REQUIRE(m.points[0].separation == Approx(gap).margin(1e-12));
    REQUIRE(norm(m.points[0].from_a - Vec3d{0.03, 0, reach + gap / 2}) < 1e-12);
  }
}

// A card lies on the floor, another falls on it, turned by a few degrees: the edges cross at one corner, and the far
// corner is a millimetre away. Turning about the crossing at 20 rad/s it is there within a millisecond.
TEST_CASE("Where edges cross nearly flat the far corners are found too") {
  const Shape card = Shape::box({0.05, 0.03, 0.001});
  const Quatd tilt = turn({0, 1, 0}, 0.1) * turn({1, 0, 0}, 0.02);
  const double margin = 3e-3;
  for (const double gap : {2e-4, -2e-4}) {
    // B's lower edge along y, at its own x = 0.05, begins 5 mm before A's edge at y = -0.03 and rises from there.
    const Vec3d begin = rotate(tilt, Vec3d{0.05, -0.03, -0.001}), along = rotate(tilt, Vec3d{0, 1, 0});
    const double rise = 0.005 * along.z / along.y;
    const Posed above{{0.02 - begin.x, -begin.y - 0.035, 0.001 + gap - rise - begin.z}, tilt};
    const auto m = touch(card, {}, card, above, margin);
    INFO("gap " << gap << ", " << m.count << " points, normal " << m.normal.x << ' ' << m.normal.y);
    REQUIRE(m.count >= 2);
    double least = margin, farthest = 0;
    for (std::uint32_t i = 0; i < m.count; ++i) {
      least = std::min(least, m.points[i].separation);
      for (std::uint32_t j = 0; j < i; ++j)
        farthest = std::max(farthest, norm(m.points[i].from_a - m.points[j].from_a));
    }
    CHECK(least == Approx(gap).margin(4e-6));
    CHECK(farthest > 0.05);
  }
}

TEST_CASE("Corner to corner the gap is the distance of the corners") {
  // Along the diagonal no face looks at the other: the points found are the corners themselves.
  const double gap = 0.001;
  const Vec3d diagonal = Vec3d{1, 1, 1} * (1 / std::sqrt(3.0));
  const auto m = touch(kCube, {}, kCube, {Vec3d{0.2, 0.2, 0.2} + diagonal * gap, {}}, 0.002);
  REQUIRE(m.count == 1);
  REQUIRE(norm(m.normal - diagonal) < 1e-9);
  REQUIRE(m.points[0].separation == Approx(gap).margin(1e-9));
  REQUIRE(norm(m.points[0].from_a - (Vec3d{0.1, 0.1, 0.1} + diagonal * (gap / 2))) < 1e-9);
}

TEST_CASE("A box tipped over the edge of another touches it along that edge") {
  // B's lower face, tilted by 0.1 rad about y, lies on A's upper edge at x = 0.1, both ends of it.
  const double tilt = 0.1;
  const auto b = Shape::box({0.1, 0.05, 0.02});
  const Quatd q = turn({0, 1, 0}, tilt);
  const Vec3d lower_face_middle = rotate(q, Vec3d{0, 0, -0.02});
  const auto m = touch(kCube, {}, b, {Vec3d{0.1, 0, 0.1} - lower_face_middle, q}, 5e-4);
  REQUIRE(m.count == 2);
  REQUIRE(norm(m.normal - rotate(q, Vec3d{0, 0, 1})) < 1e-12);
  for (const double y : {-0.05, 0.05}) REQUIRE(has_point(m, {0.1, y, 0.1}));
  REQUIRE(std::abs(least_separation(m)) < 1e-12);
}

TEST_CASE("A card's edge on a face keeps two points, at any lean, and a lying card four") {
  const auto floor = Shape::box({0.5, 0.5, 0.01});
  for (const double lean : {0.3, 0.7, kPi / 4, 1.0, 1.3, 1.5}) {  // from the floor
    INFO("lean " << lean);
    const Posed card{{0.01, 0.02, 0.01 + 0.05 * std::sin(lean) + 0.00015 * std::cos(lean) - 5e-6},
                     turn({0, 1, 0}, -lean)};
    // Close to upright the two edges of the card's thin side are both within reach of the load.
    require_steady(floor, {}, kCard, card, lean > 1.4 ? 4 : 2);
  }
  require_steady(floor, {}, kCard, {{0, 0, 0.01015 - 5e-6}, {}}, 4);
  require_steady(kCard, {}, kCard, {{0.01, 0.005, 0.0003 - 5e-6}, turn({0, 0, 1}, 0.2)}, 4);
}

TEST_CASE("Two cards that lean on each other keep two points along their upper edges") {
  for (const double lean : {1.1, 1.2, 1.3}) {
    INFO("lean " << lean);
    // A leans to the right, B to the left; their upper inner edges meet at x = 0.
    const double foot = 0.05 * std::cos(lean) + 0.00015 * std::sin(lean) - 2e-6, height = 0.05 * std::sin(lean);
    const Vec3d normal = require_steady(kCard, {{-foot, 0, height}, turn({0, 1, 0}, -lean)}, kCard,
                                        {{foot, 0, height}, turn({0, 1, 0}, lean)}, 2, 0.999);
    REQUIRE(normal.x == Approx(1).margin(1e-9));  // neither card's face, but between them
  }
}

TEST_CASE("Where two leaning cards slide past each other the normal goes over from one's face to the other's") {
  const double lean = 1.2, foot = 0.05 * std::cos(lean) + 0.00015 * std::sin(lean) - 2e-6,
               height = 0.05 * std::sin(lean);
  double last = 1;
  for (int step = -200; step <= 200; ++step) {  // B from below A's edge to above it, by a micrometre
    const auto m = touch(kCard, {{-foot, 0, height}, turn({0, 1, 0}, -lean)}, kCard,
                         {{foot, 0, height + 1e-6 * step}, turn({0, 1, 0}, lean)}, 5e-4);
    REQUIRE(m.count >= 1);
    REQUIRE(m.normal.x >= std::sin(lean) - 1e-9);
    const double rise = m.normal.z;
    if (step > -200) REQUIRE(std::abs(rise - last) < 0.02);
    last = rise;
    if (std::abs(step) == 200) REQUIRE(std::abs(rise) == Approx(std::cos(lean)).margin(1e-9));
  }
}

TEST_CASE("Where two cards overlap by a hair at one edge their broad faces press, not the narrow ones") {
  // B lies on A's end: 2 um deep along z, only 1 um along x.
  const auto m = touch(kCard, {}, kCard, {{0.1 - 1e-6, 0, 0.0003 - 2e-6}, {}}, 5e-4);
  REQUIRE(m.count > 0);
  REQUIRE(m.normal == Vec3d{0, 0, 1});
}

TEST_CASE("A card on the ridge of two cards keeps two points on each") {
  // The ridge of one leaning card, seen from the deck that lies on it.
  const double lean = 1.2, top = 0.05 * std::sin(lean) + 0.00015 * std::cos(lean);
  require_steady(kCard, {{0, 0, 0}, turn({0, 1, 0}, -lean)}, kCard, {{0.02, 0, top + 0.00015 - 5e-6}, {}}, 2);
}

TEST_CASE("A stack keeps its names under load, also where faces are equally good") {
  require_steady(kCube, {}, kCube, {{0, 0, 0.2 - 5e-6}, {}}, 4);
  require_steady(kCube, {}, kCube, {{0.03, 0.05, 0.2 - 5e-6}, turn({0, 0, 1}, 0.3)}, 4);
}

TEST_CASE("Boxes that are apart remember the axis with the widest gap, the lower one on a tie") {
  AxisCache cache;
  const auto at = [&](const Vec3d& position) {
    return collide({kCube, {}}, {kCube, {position, {}}}, {.margin = 1e-3}, cache);
  };
  REQUIRE(at({0.25, 0, 0}).count == 0);
  REQUIRE(cache.axis == 1);
  REQUIRE(at({0.25, 0.25, 0}).count == 0);
  REQUIRE(cache.axis == 1);  // y separates as much
  REQUIRE(at({0.1, 0.25, 0}).count == 0);
  REQUIRE(cache.axis == 2);
  REQUIRE(at({0.1, 0.2, 0}).count == 4);
  REQUIRE(cache.axis == 2);
}

TEST_CASE("The cached face stays the reference until another is better by more than the preference") {
  // B sits on the edge of A: x overlaps by 10 mm, z by 10 mm + d.
  const auto overlap_z = [&](double d, std::uint8_t axis) {
    AxisCache cache{axis};
    (void)collide({kCube, {}}, {kCube, {{0.19, 0, 0.19 - d}, {}}}, {.margin = 1e-3}, cache);
    return cache.axis;
  };
  const double preference = 0.05 * 0.01 + 1e-5;  // 5 % of the overlap and 10 um
  for (const double d : {-0.8 * preference, 0.0, 0.8 * preference}) {
    REQUIRE(overlap_z(d, 1) == 1);
    REQUIRE(overlap_z(d, 3) == 3);
  }
  REQUIRE(overlap_z(-1.3 * preference, 1) == 3);
  REQUIRE(overlap_z(1.3 * preference, 3) == 1);
}

TEST_CASE("A box that runs into the side of another is stopped, although it is a little above its foot") {
  for (const double above : {2e-4, 1e-2, 0.1}) {  // by which the two overlap in height
    CAPTURE(above);
    AxisCache cache;
    for (double x = -3e-4; x < 5e-5; x += 2e-5) {
      const auto m = collide({kCube, {}}, {kCube, {{-0.2 + x, 0, 0.2 - above}, {}}}, {.margin = 1e-3}, cache);
      REQUIRE(m.count > 0);
      REQUIRE(m.normal == Vec3d{-1, 0, 0});
    }
  }
}

TEST_CASE("Whatever the cache says, touching boxes are found and nothing is overstated") {
  Random random(12);
  int touching = 0;
  for (int n = 0; n < tries(3000); ++n) {
    const PosedBox a{random_shape(random, ShapeKind::kBox).half_extents, random.pose(0.1)},
        b{random_shape(random, ShapeKind::kBox).half_extents, random.pose(0.1)};
    const double truth = distance(a, b);
    AxisCache cache{static_cast<std::uint8_t>(random.below(256))};
    const auto m = collide({Shape::box(a.half), a.pose}, {Shape::box(b.half), b.pose}, {.margin = 5e-3}, cache);
    if (truth <= 5e-3 - 1e-9) {
      REQUIRE(m.count > 0);
      REQUIRE(least_separation(m) <= truth + 1e-9);
      ++touching;
    }
    REQUIRE(cache.axis <= 15);
  }
  REQUIRE(touching > tries(300));
}

TEST_CASE("Pushing the boxes apart by the reported overlap leaves next to none") {
  Random random(13);
  for (int n = 0; n < tries(2000); ++n) {
    const PosedBox a{Vec3d{0.05, 0.06, 0.07}, random.pose(0.01)};
    PosedBox b{Vec3d{0.04, 0.05, 0.08}, {a.pose.position, random.rotation()}};
    const Vec3d direction = random.direction();
    while (overlap(a, b)) b.pose.position += direction * 1e-3;  // now apart by less than a millimetre
    b.pose.position -= direction * 1e-3;
    const auto m = touch(Shape::box(a.half), a.pose, Shape::box(b.half), b.pose, 0.0);
    REQUIRE(m.count > 0);
    // Shallow overlap: the preference (5 % and 10 um) and the part beside the reference face are all that may remain.
    b.pose.position += m.normal * (1.1 * -least_separation(m) + 3e-5);
    PosedBox inner = b;
    inner.half = inner.half - Vec3d{1e-5, 1e-5, 1e-5};
    REQUIRE_FALSE(overlap(a, inner));
  }
}
