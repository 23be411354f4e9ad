// The generators: how many bodies, where they touch, that they overlap nowhere, the same bits each time.
#include "sim/loader/generators.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numeric>

#include "rt/physics/collision/manifold.h"

using namespace tactus;
using namespace tactus::sim;
using physics::Body;

namespace {

constexpr double kMargin_m = 5e-4;

physics::Manifold touch(const Body& a, const Body& b) {
  physics::AxisCache cache;
  return physics::collide(posed_shape(a), posed_shape(b), {.margin = kMargin_m}, cache);
}

const Body kGround = physics::make_fixed_body(kNoBody, physics::Shape::plane(), 0.5, Posed{});

double least_separation(const physics::Manifold& manifold) {
  double least = kMargin_m;
  for (std::uint32_t i = 0; i < manifold.count; ++i) least = std::min(least, manifold.points[i].separation);
  return least;
}

// All pairs, the ground included as the last: who touches whom within a micrometre. Checks that nobody overlaps.
std::vector<std::pair<std::size_t, std::size_t>> contacts_without_overlap(Bodies bodies) {
  bodies.push_back(kGround);
  std::vector<std::pair<std::size_t, std::size_t>> contacts;
  double deepest = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i)
    for (std::size_t j = i + 1; j < bodies.size(); ++j) {
      if (bodies[i].kind == physics::BodyKind::kFixed && bodies[j].kind == physics::BodyKind::kFixed) continue;
      const bool near = bounds_of(bodies[i].shape, bodies[i].motion.pose, kMargin_m)
                            .overlaps(bounds_of(bodies[j].shape, bodies[j].motion.pose, kMargin_m));
      if (!near) continue;
      const double separation = least_separation(touch(bodies[i], bodies[j]));
      deepest = std::min(deepest, separation);
      if (separation < 1e-6) contacts.emplace_back(i, j);
    }
  CHECK(deepest > -1e-6);
  return contacts;
}

bool same_bits(const Bodies& a, const Bodies& b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](const auto& p, const auto& q) {
           return p.motion == q.motion && p.shape == q.shape && p.mass == q.mass && p.inertia == q.inertia;
         });
}

double top_of(const Bodies& bodies) {
  double top = 0;
  for (const auto& b : bodies) top = std::max(top, bounds_of(b.shape, b.motion.pose, 0.0).upper.z);
  return top;
}

}  // namespace

TEST_CASE("a wall has one brick more in every other course, and every brick rests on something") {
  for (const auto& [columns, rows] : {std::pair{2u, 1u}, {5u, 4u}, {8u, 7u}}) {
    WallSpec spec;
    spec.columns = columns;
    spec.rows = rows;
    spec.gap_m = 0.002;
    const Bodies wall = make_wall(spec);
    CHECK(wall.size() == columns * rows + rows / 2);
    CHECK(wall.size() == count_of(spec));
    CHECK(top_of(wall) == Approx(rows * spec.brick_m.z));
    const auto contacts = contacts_without_overlap(wall);
    // With gaps there is nothing beside; the ground carries a course; each whole brick above rests on two. An odd
    // course has columns - 1 whole bricks on two and two halves on one; an even one has columns bricks on two each.
    unsigned expected = columns;
    for (unsigned row = 1; row < rows; ++row) expected += 2 * columns;
    CHECK(contacts.size() == expected);
    double volume = 0, mass = 0;
    for (const auto& b : wall) {
      volume += volume_of(b.shape);
      mass += b.mass;
    }
    CHECK(mass == Approx(volume * spec.mass_kg / (spec.brick_m.x * spec.brick_m.y * spec.brick_m.z)));
  }
}

TEST_CASE("a pile has its cubes and four walls, overlaps nowhere, and its contacts link all of it") {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    PileSpec spec;
    spec.count = 300;
    spec.layers = 6;
    spec.seed = seed;
    const Bodies pile = make_pile(spec);
    REQUIRE(pile.size() == 304);
    CHECK(count_of(spec) == 304);
    for (std::size_t i = 0; i < 4; ++i) CHECK(pile[i].kind == physics::BodyKind::kFixed);
    // Union of the cubes that touch; the ground and the walls link nothing.
    std::vector<std::size_t> root(pile.size() + 1);
    std::iota(root.begin(), root.end(), 0u);
    const std::function<std::size_t(std::size_t)> find = [&](std::size_t i) {
      return root[i] == i ? i : root[i] = find(root[i]);
    };
    for (const auto& [i, j] : contacts_without_overlap(pile))
      if (i >= 4 && j < pile.size()) root[find(i)] = find(j);
    for (std::size_t i = 4; i < pile.size(); ++i) REQUIRE(find(i) == find(4));
  }
}

TEST_CASE("the seed of a pile decides it to the bit") {
  PileSpec spec;
  const Bodies first = make_pile(spec);
  CHECK(same_bits(first, make_pile(spec)));
  spec.seed = 2;
  CHECK_FALSE(same_bits(first, make_pile(spec)));
}

TEST_CASE("a pile keeps its cubes apart for every gap that a scene may ask for") {
  for (const double gap : {0.0, 0.01, 0.1, 0.2})
    for (const unsigned count : {1u, 7u, 100u}) {
      PileSpec spec;
      spec.count = count;
      spec.layers = 3;
      spec.gap_fraction = gap;
      contacts_without_overlap(make_pile(spec));
    }
}

TEST_CASE("a tower's blocks rest on each other, in crossed layers where there are several") {
  TowerSpec spec;
  spec.layers = 5;
  spec.blocks_per_layer = 3;
  const Bodies tower = make_tower(spec);
  CHECK(tower.size() == 15);
  CHECK(top_of(tower) == Approx(5 * spec.block_m.z));
  // 3 on the ground, 3 x 3 between layers, 2 side by side in each layer.
  CHECK(contacts_without_overlap(tower).size() == 3 + 4 * 9 + 5 * 2);
  spec.layers = 20;
  spec.blocks_per_layer = 1;
  CHECK(contacts_without_overlap(make_tower(spec)).size() == 20);
}

TEST_CASE("a card house has L (3 L + 1) / 2 cards that touch exactly where they should") {
  for (const unsigned levels : {1u, 2u, 3u, 5u})
    for (const double angle : {0.15, 0.25, 0.28}) {
      CardHouseSpec spec;
      spec.levels = levels;
      spec.angle_rad = angle;
      const Bodies house = make_card_house(spec);
      CHECK(house.size() == levels * (3 * levels + 1) / 2);
      CHECK(house.size() == count_of(spec));
      // Level k has n = L - k pairs: 2 n feet, n tops that meet, and n - 1 flat cards on two tops each.
      unsigned expected = 0;
      for (unsigned n = 1; n <= levels; ++n) expected += 2 * n + n + 2 * (n - 1);
      CHECK(contacts_without_overlap(house).size() == expected);
      // A leaning card reaches L cos + t sin high; a flat card is t thick.
      const double leg = spec.card_m.y * std::cos(angle) + spec.card_m.z * std::sin(angle);
      CHECK(top_of(house) == Approx(levels * leg + (levels - 1) * spec.card_m.z));
    }
}

TEST_CASE("each card house is its own mirror image, so that it has no side to fall to") {
  CardHouseSpec spec;
  const Bodies house = make_card_house(spec);
  Vec3d moment;
  for (const auto& b : house) moment += b.motion.pose.position;
  CHECK(std::abs(moment.x) < 1e-12);
  CHECK(moment.y == 0);
}

TEST_CASE("the friction that a card house needs is that of the torques about its feet") {
  CardHouseSpec spec;
  spec.angle_rad = 0.25;
  // From the foot, a corner, to the corner that carries, and to the tops' contact: less than tan by the thickness.
  const double aside = spec.card_m.y * std::sin(0.25) - spec.card_m.z * std::cos(0.25);
  const double tangent = aside / (spec.card_m.y * std::cos(0.25));
  spec.levels = 1;  // a card alone: its weight acts half way up, mu = tan / 2
  REQUIRE(needs_of(spec).foot_friction.size() == 1);
  CHECK(needs_of(spec).foot_friction[0] == Approx(0.5 * tangent));
  CHECK(needs_of(spec).top_friction == 0);  // two cards alike press on each other level
  spec.levels = 2;  // below, the inner cards carry half of a flat card and of a pair: 1.5 weights
  REQUIRE(needs_of(spec).foot_friction.size() == 2);
  CHECK(needs_of(spec).foot_friction[0] == Approx((0.5 + 1.5) / (1 + 1.5) * tangent));
  CHECK(needs_of(spec).foot_friction[1] == Approx(0.5 * tangent));
  // The flat card pulls at the corner that it lies on.
  CHECK(needs_of(spec).top_friction ==
        Approx(aside / (spec.card_m.y * std::cos(0.25) + spec.card_m.z * std::sin(0.25))));
  // A load that grows brings it to tan: never above, so tan is enough for any height.
  spec.levels = 20;
  for (const double needed : needs_of(spec).foot_friction) CHECK(needed < tangent);
}

TEST_CASE("the feet of a card house carry all of its weight") {
  // Each level hands down what it carries: with all cards alike, the sum over the feet is the number of cards. The
  // most loaded foot of three levels: half of (flat + pair + what the middle of that pair's inner card carries).
  CardHouseSpec spec;
  spec.levels = 3;
  spec.angle_rad = 0.2;
  const double tangent = std::tan(0.2) - spec.card_m.z / spec.card_m.y;
  // Level 1: inner cards carry 1.5. Level 0: flat cards 1 and 2 each bear one pair with one loaded card: 1 + 2 + 1.5.
  const double p = 0.5 * (1 + 2 + 1.5);
  CHECK(needs_of(spec).foot_friction[0] == Approx((0.5 + p) / (1 + p) * tangent));
}

TEST_CASE("dominoes stand in a row, each on the ground alone") {
  DominoRowSpec spec;
  spec.count = 30;
  const Bodies row = make_domino_row(spec);
  REQUIRE(row.size() == 30);
  CHECK(contacts_without_overlap(row).size() == 30);
  CHECK(row[1].motion.pose.position.x - row[0].motion.pose.position.x == Approx(spec.spacing_m));
  CHECK(row[0].motion.pose.position.x == Approx(-row[29].motion.pose.position.x));
}
