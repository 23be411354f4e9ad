// Hulls in contact: configurations with known points, and what hulls do in a world.
#include <catch2/catch.hpp>

#include "tests/rt/physics/shapes/hull_support.h"
#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using namespace tactus::physics::support;

namespace {

struct HullBench {
  explicit HullBench(std::vector<Hull> list) : hulls(std::move(list)), world({}, {hulls, {}, {}}) {
    settings.gravity = {0, 0, -tactus::test::kGravity};
    world.insert(make_fixed_body(100, Shape::plane(), 0.5, {}));
  }
  void add(BodyId id, std::uint32_t hull, double mass, const Posed& pose) {
    auto body = make_dynamic_body(id, Shape::convex(hulls[hull], hull), mass, 0.5, pose);
    body.inertia = hulls[hull].inertia_per_kg * mass;
    world.insert(body);
  }
  void run(int steps) {
    for (int i = 0; i < steps; ++i) {
      world.begin_step(settings);
      find_pairs_brute_force(world.bounds(), world.dynamic_pairs());
      report = world.finish_step(settings);
    }
  }

  std::vector<Hull> hulls;
  World world;
  StepSettings settings;
  StepReport report;
};

Manifold touch_hulls(const std::vector<Hull>& hulls, const Shape& a, const Posed& pose_a, const Shape& b,
                     const Posed& pose_b, double margin) {
  AxisCache cache;
  return collide({a, pose_a}, {b, pose_b}, {.margin = margin}, cache, hulls);
}

}  // namespace

TEST_CASE("Two prisms of 32 sides end to end meet in four points far apart") {
  const std::vector<Hull> hulls{prism_hull(32, 0.1, 0.05).hull};
  const auto prism = Shape::convex(hulls[0], 0);
  const auto m = touch_hulls(hulls, prism, {}, prism, {{0.01, 0, 0.099}, turn({0, 0, 1}, 0.05)}, 1e-3);
  REQUIRE(m.count == 4);
  REQUIRE(norm(m.normal - Vec3d{0, 0, 1}) < 1e-12);
  double area = 0;
  for (std::uint32_t i = 0; i < 4; ++i) {
    REQUIRE(m.points[i].separation == Approx(-0.001).margin(1e-12));
    REQUIRE(m.points[i].from_a.z == Approx(0.0495).margin(1e-12));
    for (std::uint32_t j = 0; j < i; ++j)
      for (std::uint32_t k = 0; k < j; ++k)
        area = std::max(
            area,
            0.5 * std::abs(cross(m.points[j].from_a - m.points[i].from_a, m.points[k].from_a - m.points[i].from_a).z));
  }
  REQUIRE(area > 0.0095 * 0.9);  // half of the square in a circle of 0.1 is 0.01
}

TEST_CASE("The edges of two hulls that cross touch in the middle between them") {
  const std::vector<Hull> hulls{box_hull({0.1, 0.1, 0.1}).hull};
  const auto cube = Shape::convex(hulls[0], 0);
  const double diagonal = 0.1 * std::sqrt(2.0);
  const Posed below{{0, 0, 0}, turn({1, 0, 0}, 0.25 * tactus::test::kPi)};
  const Posed above{{0.02, 0.03, 2 * diagonal - 0.002}, turn({0, 1, 0}, 0.25 * tactus::test::kPi)};
  const auto m = touch_hulls(hulls, cube, below, cube, above, 1e-3);
  REQUIRE(m.count == 1);
  REQUIRE(norm(m.normal - Vec3d{0, 0, 1}) < 1e-12);
  REQUIRE(m.points[0].separation == Approx(-0.002).margin(1e-12));
  REQUIRE(norm(m.points[0].from_a - Vec3d{0.02, 0, diagonal - 0.001}) < 1e-12);
}

TEST_CASE("Where edges of two hulls cross nearly flat the far corners are found too, as between boxes") {
  const std::vector<Hull> hulls{box_hull({0.05, 0.03, 0.001}).hull};
  const auto hull = Shape::convex(hulls[0], 0), box = Shape::box({0.05, 0.03, 0.001});
  Random random(3);
  std::uint32_t crossings = 0;
  for (int n = 0; n < 4000; ++n) {
    const Posed above{random.vector(0.06) + Vec3d{0, 0, random(0.002, 0.008)},
                      quat_from_rotation_vector(random.vector(0.1))};
    const Manifold of_hulls = touch_hulls(hulls, hull, {}, hull, above, 3e-3);
    AxisCache cache;
    const Manifold of_boxes = collide({box, {}}, {box, above}, {.margin = 3e-3}, cache);
    if (cache.axis < 7 || of_boxes.count < 2 || norm(of_hulls.normal - of_boxes.normal) > 1e-9) continue;
    ++crossings;
    INFO("pair " << n);
    REQUIRE(of_hulls.count == of_boxes.count);
    double deepest = 1, of_hulls_deepest = 1;
    for (std::uint32_t i = 0; i < of_boxes.count; ++i) {
      deepest = std::min(deepest, of_boxes.points[i].separation);
      of_hulls_deepest = std::min(of_hulls_deepest, of_hulls.points[i].separation);
    }
    REQUIRE(of_hulls_deepest == Approx(deepest).margin(1e-9));
  }
  REQUIRE(crossings > 20);
}

TEST_CASE("Two hulls corner to corner report the distance, along the line between the corners") {
  const std::vector<Hull> hulls{box_hull({0.1, 0.1, 0.1}).hull};
  const auto cube = Shape::convex(hulls[0], 0);
  const double gap = 0.003;
  const Vec3d n = Vec3d{1, 1, 1} * (1 / std::sqrt(3.0));
  const auto m = touch_hulls(hulls, cube, {}, cube, {Vec3d{0.2, 0.2, 0.2} + n * gap, {}}, 0.005);
  REQUIRE(m.count == 1);
  REQUIRE(norm(m.normal - n) < 1e-9);
  REQUIRE(m.points[0].separation == Approx(gap).margin(1e-12));
}

TEST_CASE("A hull lies on a plane with the corners of one face") {
  const std::vector<Hull> hulls{prism_hull(5, 0.1, 0.05).hull};
  const auto prism = Shape::convex(hulls[0], 0);
  const auto m = touch_hulls(hulls, prism, {{1, 2, 0.0499}, {}}, Shape::plane(), {}, 1e-3);
  REQUIRE(m.count == 4);
  REQUIRE(norm(m.normal - Vec3d{0, 0, -1}) < 1e-12);
  for (std::uint32_t i = 0; i < 4; ++i) REQUIRE(m.points[i].separation == Approx(-1e-4).margin(1e-12));
  const auto side =
      touch_hulls(hulls, prism,
                  {{0, 0, 0.1 * sin_cos(0.4 * tactus::test::kPi).sin - 1e-4}, turn({1, 0, 0}, 0.5 * tactus::test::kPi)},
                  Shape::plane(), {}, 1e-3);
  REQUIRE(side.count == 2);  // on the edge between two of its five sides
  for (std::uint32_t i = 0; i < 2; ++i) REQUIRE(side.points[i].separation == Approx(-1e-4).margin(1e-12));
}

TEST_CASE("A capsule lies on a hull's face with two points, and along its edge too") {
  const std::vector<Hull> hulls{box_hull({0.1, 0.2, 0.3}).hull};
  const auto box = Shape::convex(hulls[0], 0);
  const auto capsule = Shape::capsule(0.02, 0.05);
  const auto on_face =
      touch_hulls(hulls, capsule, {{0.01, 0.02, 0.319}, turn({0, 1, 0}, 0.5 * tactus::test::kPi)}, box, {}, 0.002);
  REQUIRE(on_face.count == 2);
  for (std::uint32_t i = 0; i < 2; ++i) REQUIRE(on_face.points[i].separation == Approx(-0.001).margin(1e-12));
  const Vec3d diagonal = Vec3d{1, 0, 1} * (1 / std::sqrt(2.0));
  const auto on_edge =
      touch_hulls(hulls, capsule, {Vec3d{0.1, 0.05, 0.3} + diagonal * 0.021, turn({1, 0, 0}, -0.5 * tactus::test::kPi)},
                  box, {}, 0.002);
  REQUIRE(on_edge.count == 2);
  REQUIRE(norm(on_edge.normal + diagonal) < 1e-12);
  for (std::uint32_t i = 0; i < 2; ++i) REQUIRE(on_edge.points[i].separation == Approx(0.001).margin(1e-12));
}

TEST_CASE("A tower of hulls stands, as deep in each other as boxes are") {
  HullBench bench({box_hull({0.05, 0.05, 0.05}).hull});
  tactus::test::PhysicsBench boxes;
  boxes.settings = bench.settings;
  boxes.add_ground(100, 0.5);
  boxes.add_stack(0, 5, 0.05, 0.3, 0.5);
  for (std::uint32_t k = 0; k < 5; ++k) bench.add(k, 0, 0.3, {{0, 0, 0.05 * (2 * k + 1)}, {}});
  bench.run(2000);
  boxes.run(2000);
  for (std::uint32_t k = 0; k < 5; ++k) {
    const auto& body = bench.world.bodies()[k].motion;
    REQUIRE(body.pose.position.z == Approx(boxes.position(k).z).margin(1e-6));
    INFO("hulls at x " << body.pose.position.x << ", boxes at " << boxes.position(k).x);
    CHECK(std::abs(body.pose.position.x) < 2e-5);  // as far as the boxes go while they settle
    REQUIRE(norm(body.velocity.linear) < 1e-5);
  }
}

TEST_CASE("A prism of 32 sides and a tetrahedron come to rest on the ground and stay") {
  HullBench bench(
      {prism_hull(32, 0.05, 0.04).hull, hull_around({{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}}).hull});
  bench.add(0, 0, 0.5, {{0, 0, 0.06}, turn({1, 0, 0}, 0.1)});
  bench.add(1, 1, 0.5, {{0.5, 0, 0.08}, turn({0.3, 1, 0}, 0.7)});
  bench.run(3000);
  const std::vector<BodyMotion> before{bench.world.bodies()[0].motion, bench.world.bodies()[1].motion};
  for (const auto& motion : before) REQUIRE(norm(motion.velocity.linear) < 1e-4);
  bench.run(1000);
  for (std::size_t k = 0; k < 2; ++k)
    REQUIRE(norm(bench.world.bodies()[k].motion.pose.position - before[k].pose.position) < 1e-5);
  REQUIRE(bench.report.deepest_m < 1e-3);
}

TEST_CASE("A world of hulls restored in every step gives the same bits: a gap that is remembered is no state") {
  Random random(9);
  const std::vector<Hull> hulls{prism_hull(6, 0.05, 0.03).hull, random_hull(random, 20, 0.06).hull,
                                random_hull(random, 8, 0.05).hull};
  const auto dropped = [&] {
    auto bench = std::make_unique<HullBench>(hulls);
    for (std::uint32_t k = 0; k < 12; ++k)
      bench->add(k, k % 3, 0.3, {{0.07 * (k % 2), 0.06 * (k % 3), 0.1 + 0.08 * k}, turn({1, 0.5, 0.2}, 0.4 * k)});
    return bench;
  };
  auto plain = dropped(), restored = dropped();
  std::vector<std::byte> bytes;
  for (int step = 0; step < 800; ++step) {
    plain->run(1);
    bytes.resize(restored->world.save_size_bound());
    ByteWriter out(bytes);
    restored->world.save(out);
    REQUIRE(out.ok());
    auto next = std::make_unique<HullBench>(hulls);
    ByteReader in(std::span<const std::byte>(bytes).first(out.size()));
    REQUIRE(next->world.restore(in));
    next->run(1);
    INFO("step " << step);
    REQUIRE(next->world.state_hash() == plain->world.state_hash());
    restored = std::move(next);
  }
}

TEST_CASE("A heap of hulls rests as deep and as quiet whether its contacts are carried over or recomputed") {
  Random random(4);
  const std::vector<Hull> hulls{prism_hull(6, 0.05, 0.03).hull, box_hull({0.04, 0.05, 0.03}).hull,
                                random_hull(random, 20, 0.06).hull};
  for (const bool carried : {false, true}) {
    HullBench bench(hulls);
    if (!carried) bench.settings.recycle_tolerance_m = 0;
    bench.world.insert(make_fixed_body(101, Shape::box({1, 1, 0.05}), 0.5, {{0, 0, 0.1}, {}}));
    for (std::uint32_t k = 0; k < 9; ++k)
      bench.add(k, k % 3, 0.3, {{0.05 * (k % 2), 0.04 * (k % 3), 0.25 + 0.12 * k}, turn({1, 0.5, 0.2}, 0.4 * k)});
    bench.run(6000);
    INFO((carried ? "carried over" : "recomputed"));
    CHECK(bench.world.kinetic_energy() < 9 * 0.5 * 0.3 * 1e-12);
    CHECK(bench.report.deepest_m < 2e-4);
    CHECK(bench.report.contacts >= 9);
    INFO(bench.report.contacts << " contacts, " << bench.report.searched << " searched");
    CHECK(
        (carried ? bench.report.searched < bench.report.contacts / 2 : bench.report.searched >= bench.report.contacts));
  }
}

TEST_CASE("A world with hulls goes on from its bytes with the same bits") {
  Random random(1);
  std::vector<Hull> hulls;
  for (const std::uint32_t vertices : {8u, 20u, 12u}) hulls.push_back(random_hull(random, vertices, 0.1).hull);
  HullBench bench(hulls);
  for (std::uint32_t k = 0; k < 6; ++k) bench.add(k, k % 3, 0.3, {{0.02 * k, 0, 0.1 + 0.15 * k}, random.rotation()});
  bench.run(300);
  REQUIRE(bench.report.contacts > 0);
  std::vector<std::byte> bytes(bench.world.save_size_bound());
  ByteWriter out(bytes);
  bench.world.save(out);
  REQUIRE(out.ok());
  HullBench other(hulls);
  ByteReader in(std::span<const std::byte>(bytes).first(out.size()));
  REQUIRE(other.world.restore(in));
  bench.run(200);
  other.run(200);
  REQUIRE(bench.world.state_hash() == other.world.state_hash());

  HullBench poorer({hulls[0], hulls[1]});  // it does not know the third hull
  ByteReader again(std::span<const std::byte>(bytes).first(out.size()));
  REQUIRE_FALSE(poorer.world.restore(again));
}

TEST_CASE("The more vertices two hulls have the more comparisons of boxes they are counted as") {
  const auto comparisons_of = [](std::uint32_t sides) {
    HullBench bench({prism_hull(sides, 0.05, 0.05).hull});
    bench.add(0, 0, 0.3, {{0, 0, 1}, {}});
    bench.add(1, 0, 0.3, {{0, 0, 1.1001}, {}});  // far from the ground, all but touching
    bench.run(1);
    REQUIRE(bench.report.searched == 1);
    return bench.report.comparisons;
  };
  CHECK(comparisons_of(3) == 1);   // 6 vertices each
  CHECK(comparisons_of(8) == 3);   // 16
  CHECK(comparisons_of(32) == 9);  // 64
}
