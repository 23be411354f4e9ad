// Bodies that slide from one body onto the next at the same height pass; those that meet an edge are stopped.
#include "rt/physics/contact/flush_seams.h"

#include <catch2/catch.hpp>
#include <memory>
#include <string>

#include "tests/rt/physics/shapes/hull_support.h"
#include "tests/support/physics_bench.h"

using namespace tactus;
using namespace tactus::physics;
using tactus::test::kGravity;

namespace {

constexpr double kTile = 0.2;    // m, length of a tile along x
constexpr double kHalf = 0.025;  // m, half the size of what slides
constexpr BodyId kSlider = 20;
constexpr double kThick = 0.04;  // m, of a tile

// A world with the shapes that the tests need: hull 0 is a tile, hull 1 a prism, compound 0 a tile of two boxes,
// compound 1 a box and a prism beside each other.
struct Floor {
  std::vector<Hull> hulls;
  std::vector<CompoundPart> tile_parts, cup_parts;
  std::vector<Compound> compounds;
  std::unique_ptr<World> world;
  StepSettings settings;
  StepReport report;

  Floor() {
    hulls = {support::box_hull({kTile / 2, 0.2, kThick / 2}).hull, support::prism_hull(6, kHalf, kHalf).hull};
    for (const double x : {-0.25 * kTile, 0.25 * kTile})
      tile_parts.push_back({Shape::box({kTile / 4, 0.2, kThick / 2}), {{x, 0, 0}, {}}});
    cup_parts = {{Shape::box({kHalf, kHalf, kHalf}), {{-kHalf, 0, 0}, {}}},
                 {Shape::convex(hulls[1], 1), {{kHalf, 0, 0}, {}}}};
    compounds.resize(2);
    compounds[0].parts = tile_parts;
    compounds[0].half_extents = {kTile / 2, 0.2, kThick / 2};
    compounds[1].parts = cup_parts;
    compounds[1].half_extents = {2 * kHalf, kHalf, kHalf};
    for (Compound& compound : compounds) {
      compound.bounding_radius = norm(compound.half_extents);
      compound.half_thickness = kThick / 2;
      compound.volume = 1e-4;
      compound.inertia_per_kg = inertia_of(Shape::box(compound.half_extents), 1);
    }
    world = std::make_unique<World>(Capacities{}, ShapeLists{hulls, {}, compounds});
    settings.gravity = {0, 0, -kGravity};
  }

  Shape tile(const std::string& kind) const {
    if (kind == "hull") return Shape::convex(hulls[0], 0);
    if (kind == "compound") return compound_shape(compounds[0], 0);
    return Shape::box({kTile / 2, 0.2, kThick / 2});
  }
  Shape slider(const std::string& kind) const {
    if (kind == "hull") return Shape::convex(hulls[1], 1);
    if (kind == "compound") return compound_shape(compounds[1], 1);
    if (kind == "cylinder" || kind == "lying") return Shape::cylinder(kHalf, kHalf);
    if (kind == "cone") return Shape::cone(kHalf, kHalf);
    return Shape::box({kHalf, kHalf, kHalf});
  }
  // Tiles from x = -kTile / 2 on; each is higher than the one before by `lip` [m].
  void add_tiles(const std::string& kind, double lip, double friction = 0) {
    for (BodyId i = 0; i < 5; ++i)
      world->insert(make_fixed_body(i, tile(kind), friction, {{kTile * i, 0, -kThick / 2 + lip * i}, {}}));
  }
  void add_slider(const std::string& kind, double x, double speed, double yaw = 0) {
    const Shape shape = slider(kind);
    const double low = kind == "cone" ? 0.5 * kHalf : kHalf;
    const Vec3d turn = kind == "lying" ? Vec3d{0, test::kPi / 2, 0} : Vec3d{0, 0, yaw};
    Body body = make_dynamic_body(kSlider, shape, 0.2, 0, {{x, 0.01, low}, quat_from_rotation_vector(turn)});
    if (kind == "hull") body.inertia = 0.2 * hulls[1].inertia_per_kg;
    if (kind == "compound") body.inertia = 0.2 * compounds[1].inertia_per_kg;
    body.motion.velocity.linear = {speed, 0, 0};
    world->insert(body);
  }
  const BodyMotion& run(double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds / settings.dt)); ++i) {
      world->begin_step(settings);
      find_pairs_brute_force(world->bounds(), world->dynamic_pairs());
      report = world->finish_step(settings, {});
    }
    return world->find(kSlider)->motion;
  }
};

const char* const kTiles[] = {"box", "hull", "compound"};
const char* const kSliders[] = {"box", "hull", "cylinder", "lying", "cone", "compound"};

}  // namespace

TEST_CASE("What slides over flush tiles keeps its speed, whatever it and the tiles are") {
  for (const std::string tile : kTiles)
    for (const std::string slider : kSliders)
      for (const double speed : {0.2, 1.0, 3.0})
        for (const double yaw : {0.0, 0.3}) {
          CAPTURE(tile, slider, speed, yaw);
          Floor floor;
          floor.add_tiles(tile, 0);
          floor.add_slider(slider, 0, speed, yaw);
          const BodyMotion& motion = floor.run(0.7 / speed);
          CHECK(motion.velocity.linear.x == Approx(speed).epsilon(0.005));
          CHECK(motion.pose.position.x == Approx(0.7).epsilon(0.005));
          CHECK(std::abs(motion.velocity.linear.z) < 0.01);
          CHECK(norm(motion.velocity.angular) < 0.02);
        }
}

TEST_CASE("What rests at a seam follows a slight slope over it, however slowly") {
  for (const std::string tile : kTiles)
    for (const std::string slider : kSliders)
      for (const double front : {-1e-6, 0.0, 1e-6}) {
        CAPTURE(tile, slider, front);
        Floor floor;
        floor.add_tiles(tile, 0);
        const double half = slider == "compound" ? 2 * kHalf : kHalf;
        floor.add_slider(slider, kTile / 2 - half + front, 0);
        const double pull = 0.01 * kGravity;
        floor.settings.gravity.x = pull;
        const double start = kTile / 2 - half + front;
        const BodyMotion& motion = floor.run(1.0);
        CHECK(motion.pose.position.x - start == Approx(0.5 * pull).epsilon(0.05));
      }
}

TEST_CASE("A lip that is higher than what counts as flush stops what slides into it") {
  const double lip = GENERATE(1.7e-4, 3e-4, 2e-3);
  for (const std::string tile : kTiles)
    for (const std::string slider : kSliders) {
      CAPTURE(lip, tile, slider);
      Floor floor;
      floor.add_tiles(tile, lip);
      floor.add_slider(slider, 0, 0.05);
      const double half = slider == "compound" ? 2 * kHalf : kHalf;
      const BodyMotion& motion = floor.run(4.0);
      CHECK(motion.pose.position.x + half < kTile / 2 + 5e-5);
    }
}

TEST_CASE("A box slides from one table onto the next with each length of the step") {
  struct Way {
    double speed, lip;  // m/s; m by which the next table is higher
  };
  for (const Way way : {Way{0.02, 0.0}, Way{0.03, 1e-5}, Way{0.1, 0.0}, Way{0.1, 3e-5}})
    for (const double dt : {1e-3, 4e-3, 8e-3}) {
      CAPTURE(way.speed, way.lip, dt);
      test::PhysicsBench bench;
      bench.settings.dt = dt;
      const Shape cube = Shape::box({0.1, 0.1, 0.1});
      bench.world.insert(make_fixed_body(0, cube, 0, {{-0.1, 0, -0.1}, {}}));
      bench.world.insert(make_fixed_body(1, cube, 0, {{0.1, 0, -0.1 + way.lip}, {}}));
      bench.add_box(2, {0.03, 0.03, 0.02}, 0.2, 0, {{-0.06, 0, 0.02}, {}},
                    {.linear = {way.speed, 0, 0}, .angular = {}});
      bench.run_seconds(0.12 / way.speed);
      // It has risen by the lip: v^2 = v0^2 - 2 g lip.
      const double speed = std::sqrt(way.speed * way.speed - 2 * kGravity * way.lip);
      CHECK(bench.velocity(2).linear.x == Approx(speed).epsilon(0.07));  // part of a low lip is within the slop
      CHECK(bench.position(2).x > 0.03);
    }
}

TEST_CASE(
    "At a seam only contacts with upward normals are solved, at any overlap and however far the body is over it") {
  for (const std::string tile : kTiles)
    for (const std::string slider : kSliders)
      for (const double depth : {0.0, 2e-5, 3.3e-5, 9e-5})
        for (double over = -3e-4; over < 2e-3; over += 2.3e-5) {
          CAPTURE(tile, slider, depth, over);
          Floor floor;
          floor.add_tiles(tile, 0);
          const double half = slider == "compound" ? 2 * kHalf : kHalf;
          floor.add_slider(slider, kTile / 2 - half + over, 0);
          floor.world->find(kSlider)->motion.pose.position.z -= depth;
          (void)floor.run(floor.settings.dt);
          std::uint32_t on_next = 0;
          for (const Contact& contact : floor.world->contacts()) {
            if (contact.is_redundant()) continue;
            REQUIRE(std::abs(contact.normal.z) > 0.999);
            on_next += contact.slot_b == 1 ? contact.count : 0;
          }
          if (over < -1e-5) REQUIRE(on_next == 0);
          if (over > 1.3e-4) REQUIRE(on_next >= 1);
        }
}

TEST_CASE("Tiles that move themselves pass below what rests, and a brick slides over a course of loose bricks") {
  test::PhysicsBench bench;
  bench.add_ground(0, 0.8);
  for (BodyId i = 0; i < 4; ++i) bench.add_box(10 + i, {0.05, 0.05, 0.02}, 2, 0.8, {{0.1 * i, 0, 0.02}, {}});
  bench.add_box(20, {0.02, 0.02, 0.02}, 0.02, 0, {{0, 0, 0.06}, {}}, {.linear = {0.5, 0, 0}, .angular = {}});
  bench.run_seconds(0.5);
  CHECK(bench.velocity(20).linear.x == Approx(0.5).epsilon(0.01));
  for (BodyId i = 0; i < 4; ++i) CHECK(bench.position(10 + i).x == Approx(0.1 * i).margin(2e-4));
}

TEST_CASE("A plank leans on an edge, its foot before a kerb: what reaches below the face keeps its contact") {
  const bool as_hulls = GENERATE(false, true);
  const double lean = 0.3;  // rad from the vertical, to the right
  const Vec3d half{0.005, 0.05, 0.15};
  const Posed pose{
      {half.x * std::cos(lean) + half.z * std::sin(lean), 0, half.z * std::cos(lean) + half.x * std::sin(lean)},
      quat_from_rotation_vector(Vec3d{0, lean, 0})};
  // The kerb is at the left of the foot; the edge of the block is half way up the plank's right face.
  const Vec3d foot = pose * Vec3d{-half.x, 0, -half.z}, edge = pose * Vec3d{half.x, 0, 0.5 * half.z};
  const Vec3d kerb{0.02, 0.1, 0.02}, block{0.05, 0.1, 0.5 * edge.z};
  const std::vector<Hull> hulls{support::box_hull(half).hull, support::box_hull(kerb).hull,
                                support::box_hull(block).hull};
  const auto shape = [&](const Vec3d& box, std::uint32_t hull) {
    return as_hulls ? Shape::convex(hulls[hull], hull) : Shape::box(box);
  };
  World world({}, ShapeLists{hulls, {}, {}});
  StepSettings settings;
  settings.gravity = {0, 0, -kGravity};
  world.insert(make_fixed_body(0, Shape::plane(), 0, {}));
  world.insert(make_fixed_body(1, shape(kerb, 1), 0, {{foot.x - kerb.x, 0, kerb.z}, {}}));
  world.insert(make_fixed_body(2, shape(block, 2), 0, {{edge.x + block.x, 0, block.z}, {}}));
  Body plank = make_dynamic_body(kSlider, shape(half, 0), 0.3, 0, pose);
  plank.inertia = inertia_of(Shape::box(half), 0.3);
  world.insert(plank);
  for (int i = 0; i < 2000; ++i) {
    world.begin_step(settings);
    find_pairs_brute_force(world.bounds(), world.dynamic_pairs());
    (void)world.finish_step(settings, {});
  }
  CHECK(norm(world.find(kSlider)->motion.pose.position - pose.position) < 5e-5);
}
