// What narrow phase remembers: a pair that waits because it was apart, and a contact that is carried over.
#include "rt/physics/contact/contact_table.h"

#include <catch2/catch.hpp>
#include <memory>

#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::PhysicsBench;

namespace {

constexpr double kMargin = 5e-4;

// A pose near the other: the body's centre moves by `shift`, the body turns by `angle`, in random directions.
Posed moved(const Posed& pose, double shift, double angle, test::Random& random) {
  const auto unit = [&] { return normalized_or(random.vector(1), Vec3d{1, 0, 0}); };
  return {pose.position + shift * unit(), normalized(quat_from_rotation_vector(angle * unit()) * pose.rotation)};
}

// Boxes that fall on each other: cubes, plates and rods, so that faces, edges and corners meet.
std::vector<Body> heap(std::uint64_t seed) {
  test::Random random(seed);
  std::vector<Body> bodies;
  bodies.push_back(make_fixed_body(100, Shape::plane(), 0.6, {}));
  bodies.push_back(make_fixed_body(101, Shape::box({0.1, 0.1, 0.02}), 0.6, {{0.1, 0, 0}, {}}));
  for (BodyId id = 0; id < 27; ++id) {
    const Posed pose{{0.075 * (id % 3) + random(-0.01, 0.01), 0.075 * (id / 3 % 3), 0.06 + 0.08 * (id / 9)},
                     quat_from_rotation_vector(random.vector(0.4))};
    const Vec3d half = id % 3 == 0   ? Vec3d{0.03, 0.03, 0.03}
                       : id % 3 == 1 ? Vec3d{0.035, 0.03, 0.004}
                                     : Vec3d{0.01, 0.01, 0.035};
    bodies.push_back(make_dynamic_body(id, Shape::box(half), random(0.1, 0.5), 0.5, pose));
  }
  return bodies;
}

std::unique_ptr<PhysicsBench> bench_with(const std::vector<Body>& bodies, double tolerance_m) {
  auto bench = std::make_unique<PhysicsBench>();
  bench->settings.recycle_tolerance_m = tolerance_m;
  for (const Body& body : bodies) REQUIRE(bench->world.insert(body));
  return bench;
}

std::vector<std::byte> bytes_of(const World& world) {
  std::vector<std::byte> bytes(world.save_size_bound());
  ByteWriter out(bytes);
  world.save(out);
  REQUIRE(out.ok());
  bytes.resize(out.size());
  return bytes;
}

}  // namespace

TEST_CASE("A pair that waits because it was apart has no contact, however its bodies moved meanwhile") {
  test::Random random(1);
  int near_the_limit = 0, edges = 0;
  for (int n = 0; n < 20000; ++n) {
    const auto half = [&] { return Vec3d{random(0.002, 0.06), random(0.002, 0.06), random(0.002, 0.06)}; };
    const auto a = Shape::box(half()), b = Shape::box(half());
    const Posed at_a{random.vector(0.01), quat_from_rotation_vector(random.vector(3))};
    const Posed at_b{random.vector(0.12), quat_from_rotation_vector(random.vector(3))};
    AxisCache cache;
    const Manifold then = collide({a, at_a}, {b, at_b}, {.margin = kMargin}, cache);
    REQUIRE(then.gap <= kLargestGap);
    if (!(then.gap > kMargin)) continue;
    REQUIRE(then.count == 0);
    if (cache.axis >= 7) ++edges;
    // All that the gap allows, shared out between shifts and turns of both.
    const double use = 0.999 * (then.gap - kMargin), part = random(0, 1), of_a = random(0, 1);
    const double shift = part * use, turn = (1 - part) * use / then.lever_arm;
    const Posed now_a = moved(at_a, of_a * shift, of_a * turn, random);
    Posed now_b = moved(at_b, (1 - of_a) * shift, (1 - of_a) * turn, random);
    if (n % 2 == 0)
      now_b.position = at_b.position + (1 - of_a) * shift * normalized_or(at_a.position - at_b.position, {});
    for (const unsigned axis : {0u, 3u, 8u}) {
      AxisCache any{static_cast<std::uint8_t>(axis)};
      REQUIRE(collide({a, now_a}, {b, now_b}, {.margin = kMargin}, any).count == 0);
    }
    AxisCache fresh;
    const double left = collide({a, now_a}, {b, now_b}, {.margin = kMargin}, fresh).gap;
    if (left < then.gap) ++near_the_limit;
  }
  CHECK(near_the_limit > 1000);
  CHECK(edges > 300);
}

TEST_CASE("The bound on two bodies' relative motion is never less than the motion of any points of their surfaces") {
  test::Random random(2);
  for (int n = 0; n < 5000; ++n) {
    const double radius = random(0.01, 0.5), size = std::pow(10, random(-9, 0));
    const Posed before_a{random.vector(10), quat_from_rotation_vector(random.vector(3))};
    const Posed before_b{random.vector(10), quat_from_rotation_vector(random.vector(3))};
    const Posed now_a = moved(before_a, random(0, size), random(0, size), random);
    // Every second time B goes along with A, but for a thousandth.
    Posed now_b = moved(before_b, random(0, size), random(0, size), random);
    if (n % 2 == 0) {
      now_b = moved(before_b, random(0, 1e-3 * size), random(0, size), random);
      now_b.position += now_a.position - before_a.position;
    }
    MotionBound a, b;
    measure_motion(before_a, now_a, 0.02, a);
    measure_motion(before_b, now_b, 0.02, b);
    const Vec3d on_a = radius * normalized_or(random.vector(1), Vec3d{0, 0, 1});
    const Vec3d on_b = radius * normalized_or(random.vector(1), Vec3d{0, 0, 1});
    const Vec3d apart = (now_b * on_b - before_b * on_b) - (now_a * on_a - before_a * on_a);
    REQUIRE(moved_against(a, b, radius) >= norm(apart) - 1e-15 * 40);  // the check's own rounding at 10 m
    const double between = norm((now_b.position - now_a.position) - (before_b.position - before_a.position));
    REQUIRE(moved_against(a, b, radius) <= 1.01 * between + 2.1 * 2 * size * radius + 1e-13);
  }
  const MotionBound fixed;
  MotionBound same, along, unknown;
  measure_motion({}, {}, 0.02, same);
  CHECK(moved_against(same, fixed, 1.0) == 0);
  measure_motion({{}, {}}, {{0.5, 0, 0}, {}}, 0.02, along);
  CHECK(moved_against(along, fixed, 1.0) >= 0.5);
  CHECK(moved_against(along, along, 1.0) <= 2e-15);
  measure_motion(unknown_pose(), {}, 0.02, unknown);
  CHECK(moved_against(unknown, fixed, 1.0) == std::numeric_limits<double>::infinity());
  CHECK(moved_against(unknown, unknown, 1.0) == std::numeric_limits<double>::infinity());
}

TEST_CASE("A contact that is carried over is as deep as the two faces say, but for motion times turn") {
  test::Random random(3);
  double most_changed = 0;
  for (int n = 0; n < 3000; ++n) {
    const auto box = Shape::box({0.05, 0.05, 0.05});
    const Posed at_a{random.vector(1), quat_from_rotation_vector(random.vector(3))};
    const Posed b_on_a{{random(-0.03, 0.03), random(-0.03, 0.03), 0.1 - 2e-5},
                       quat_from_rotation_vector(Vec3d{0, 0, random(0.2, 0.6)})};
    const Posed at_b = at_a * b_on_a;
    AxisCache cache;
    const Manifold then = collide({box, at_a}, {box, at_b}, {.margin = kMargin}, cache);
    REQUIRE(then.count == 4);
    Contact contact;
    contact.normal = then.normal;
    contact.count = then.count;
    for (std::uint32_t i = 0; i < 4; ++i) {
      contact.points[i].from_a = then.points[i].from_a;
      contact.points[i].from_b = then.points[i].from_b;
      contact.points[i].separation = then.points[i].separation;
      contact.points[i].feature = then.points[i].feature;
    }
    ContactReference reference;
    reference = {.tolerance = 5e-5, .margin = kMargin, .lever_arm = 0.0866};
    store_anchors(contact, BodyFrame::of(at_a), BodyFrame::of(at_b), reference);
    const Posed now_a = moved(at_a, 1e-5, 1e-4, random), now_b = moved(at_b, 1e-5, 1e-4, random);
    carry_over(reference, BodyFrame::of(now_a), BodyFrame::of(now_b), contact);
    // The truth is the two faces that touch: top of A, bottom of B. What a new search says is not: of the eight points
    // here it chooses four, and gives the first the depth of the deepest.
    const Vec3d up_a = rotate(now_a.rotation, Vec3d{0, 0, 1}), up_b = rotate(now_b.rotation, Vec3d{0, 0, 1});
    for (std::uint32_t i = 0; i < 4; ++i) {
      const ContactPoint& point = contact.points[i];
      // The same place of the world, seen from both bodies.
      REQUIRE(norm(now_a.position + point.from_a - now_b.position - point.from_b) < 1e-14);
      const double gap = (dot(up_a, point.from_a) - 0.05) - (dot(up_b, point.from_b) + 0.05);
      // They moved by 40 um at most against each other, and each turned by 0.1 mrad: 40 um x 0.2 mrad is neglected.
      REQUIRE(std::abs(point.separation - gap) <= 4e-5 * 2e-4);
      most_changed = std::max(most_changed, std::abs(point.separation - then.points[i].separation));
    }
  }
  CHECK(most_changed > 1e-5);  // a thousand times what it is off by
}

TEST_CASE("A contact is carried over only within the tolerance and the margin, a newcomer's never") {
  ContactReference reference;
  reference.tolerance = 5e-5;
  reference.margin = 5e-4;
  CHECK(may_carry_over(reference, 5e-5, 1e-4));
  CHECK_FALSE(may_carry_over(reference, 5.1e-5, 1e-4));  // moved too far
  CHECK_FALSE(may_carry_over(reference, 4e-5, 4.7e-4));  // this step could close what was not found
  CHECK_FALSE(may_carry_over(reference, std::numeric_limits<double>::infinity(), 0.0));
  CHECK_FALSE(may_carry_over(ContactReference{}, 0.0, 0.0));
  // A card of 2 mm moves its contact by 10 um at most, whatever the settings say; no pair by more than these.
  const auto card = Shape::box({0.03, 0.04, 0.001}), cube = Shape::box({0.05, 0.05, 0.05});
  for (BodyId id = 1; id < 100; ++id) {
    const PairKey key = PairKey::of(0, id, false);
    CHECK(tolerance_of(key, card, cube, 5e-5) <= 1e-5);
    CHECK(tolerance_of(key, cube, cube, 5e-5) <= 5e-5);
    CHECK(tolerance_of(key, cube, cube, 5e-5) >= 2.5e-5);
  }
}

TEST_CASE("A world restored in every step gives the same bits: what waits is no state, what is carried over is saved") {
  const auto bodies = heap(4);
  auto plain = bench_with(bodies, 5e-5);
  auto world = bench_with(bodies, 5e-5);
  for (int k = 0; k < 600; ++k) {
    plain->step();
    auto other = std::make_unique<PhysicsBench>();
    const auto bytes = bytes_of(world->world);
    ByteReader in(bytes);
    REQUIRE(other->world.restore(in));
    other->step();
    REQUIRE(other->world.state_hash() == plain->world.state_hash());
    REQUIRE(other->report.points == plain->report.points);
    world = std::move(other);
  }
  REQUIRE(bytes_of(world->world) == bytes_of(plain->world));
}

TEST_CASE("A body that is put elsewhere from outside is found there at once") {
  for (const double tolerance : {0.0, 5e-5}) {
    PhysicsBench bench;
    bench.settings.gravity = {};
    bench.settings.recycle_tolerance_m = tolerance;
    bench.add_box(1, {0.05, 0.05, 0.05}, 1, 0.5, {{0, 0, 0}, {}});
    bench.add_box(2, {0.05, 0.05, 0.05}, 1, 0.5, {{0, 0, 0.1 - 1e-5}, {}});
    bench.run(3);
    REQUIRE(bench.report.points == 4);
    bench.position(2) = {0.10045, 0, 0.10045};  // the bounds overlap, the edges are 0.64 mm apart
    bench.run(2);
    REQUIRE(bench.report.pairs == 1);
    REQUIRE(bench.report.points == 0);
    bench.position(2) = {0, 0, 0.1 - 1e-5};
    bench.step();
    REQUIRE(bench.report.points == 4);
    // Another body of that id, elsewhere.
    bench.position(2) = {0.10045, 0, 0.10045};
    bench.run(2);
    REQUIRE(bench.world.remove(2));
    bench.add_box(2, {0.05, 0.05, 0.05}, 1, 0.5, {{0, 0, 0.1 - 1e-5}, {}});
    bench.step();
    REQUIRE(bench.report.points == 4);
  }
}

// The deepest overlap over 200 ms and the kinetic energy after them of a heap that had 3 s to come to rest.
struct Rest {
  double deepest_m, energy_J;
};
Rest rest_of(std::uint64_t seed, bool carried) {
  auto bench = bench_with(heap(seed), carried ? 5e-5 : 0.0);
  bench->run_seconds(3);
  Rest rest{};
  for (int k = 0; k < 200; ++k) {
    bench->step();
    rest.deepest_m = std::max(rest.deepest_m, bench->report.deepest_m);
  }
  rest.energy_J = bench->world.kinetic_energy();
  return rest;
}
// Of 27 bodies of 0.3 kg at 0.1 um/s.
constexpr double kAtRest_J = 27 * 0.5 * 0.3 * 1e-14;

// Minutes under a sanitizer, of steps that the other worlds take too. Of 120 heaps 3 to 5 creep on at up to 0.3 mm/s,
// carried over or not (2026-11-26): in a tower the friction of every point is at its limit, and its boxes turn about
// the vertical. Of these 60 runs three do.
TEST_CASE("A heap comes to rest as deep and as quiet whether its contacts are carried over or not", "[no-asan]") {
  int moving = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed)
    for (const bool carried : {false, true}) {
      const Rest rest = rest_of(seed, carried);
      INFO("seed " << seed << (carried ? ", carried over" : ", recomputed") << ": " << rest.deepest_m << " m, "
                   << rest.energy_J << " J");
      CHECK(rest.deepest_m < 2e-4);
      CHECK(rest.energy_J < 1e7 * kAtRest_J);
      if (!(rest.energy_J < kAtRest_J)) ++moving;
    }
  CHECK(moving <= 3);
}

TEST_CASE("Every heap whose contacts are carried over comes to rest", "[no-asan]") {
  int moving = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed)
    for (const bool carried : {false, true}) {
      const Rest rest = rest_of(seed, carried);
      CHECK(rest.energy_J < 1e6 * kAtRest_J);
      if (carried) CHECK(rest.energy_J < kAtRest_J);
      if (!(rest.energy_J < kAtRest_J)) ++moving;
    }
  CHECK(moving <= 1);
}
