#include "tools/experiment/scene.h"

#include <algorithm>
#include <cmath>

#include "rt/base/check.h"
#include "sim/geometry/hull_builder.h"
#include "sim/random.h"
#include "tools/experiment/scene_shapes.h"

namespace tactus::experiment {
namespace {

constexpr double kDensity = 1000;  // kg/m^3
// Large enough for tilted cubes, and so that a heap forms instead of columns.
constexpr double kGap = 0.4;          // of the edge, between neighbours of the grid
constexpr double kJitter = 0.05;      // of the edge, to either side; small enough that neighbours do not touch
constexpr double kMaxTilt_rad = 0.3;  // about each axis, at most
constexpr double kWallHalf_m = 0.5;   // thick enough that no body passes through

// Slope of the bowl's sides: steeper than the friction angle (27 degrees at 0.5), flatter than the angle at which a
// body pushed along the floor jams (63 degrees).
constexpr double kBowlSlope_rad = 0.6;

using sim::Random;

void add_walls(BoxScene& scene, double width_m, double height_m) {
  const double half = 0.5 * width_m, t = kWallHalf_m, tall = 0.5 * height_m, out = half + 2 * t;
  scene.walls.push_back({{out, out, t}, {0, 0, -t}});
  for (const double side : {-1.0, 1.0}) {
    scene.walls.push_back({{t, out, tall}, {side * (half + t), 0, tall}});
    scene.walls.push_back({{half, t, tall}, {0, side * (half + t), tall}});
  }
}

constexpr std::uint32_t kHulls = 16;

// Random points on a sphere, all of them vertices; log-uniform sizes.
void add_hulls(BoxScene& scene, const BoxPileSpec& spec, Random& random) {
  for (std::uint32_t k = 0; k < kHulls; ++k) {
    const double edge = spec.smallest_edge_m * std::pow(spec.largest_edge_m / spec.smallest_edge_m, k / (kHulls - 1.0));
    std::vector<Vec3d> points;
    while (points.size() < spec.hull_vertices) {
      const Vec3d p = random.vector(1);
      const double r = norm(p);
      if (r > 0.1 && r < 1) points.push_back((0.5 * edge / r) * p);
    }
    const auto built = sim::build_hull(points);
    TACTUS_CHECK(built.ok(), k, spec.seed);
    scene.hulls.push_back(built.value().hull);
  }
}

// Sets the forms of placed bodies, and their masses.
void give_forms(BoxScene& scene, const BoxPileSpec& spec) {
  Random random(spec.seed + 1);
  add_hulls(scene, spec, random);
  const double octaves = std::log(spec.largest_edge_m / spec.smallest_edge_m);
  for (Cube& body : scene.cubes) {
    body.form = spec.forms[random.next() % spec.forms.size()];
    body.hull = static_cast<std::uint32_t>(random.next() % kHulls);
    if (octaves > 0)  // the largest hull that is not larger than the body
      body.hull = static_cast<std::uint32_t>((kHulls - 1) * std::log(body.edge_m / spec.smallest_edge_m) / octaves);
    body.mass_kg = kDensity * volume_of(scene, body);
  }
}

// Sides that slope up from the edge of the floor: bodies pushed against them rise and fall back.
void add_bowl(BoxScene& scene, double floor_width_m, double height_m) {
  const double half = 0.5 * floor_width_m, t = kWallHalf_m;
  const double rise = std::sin(kBowlSlope_rad), run = std::cos(kBowlSlope_rad);
  const double along = 0.5 * height_m / rise, wide = half + 2 * along * run + 2 * t;
  scene.walls.push_back({{wide, wide, t}, {0, 0, -t}});
  for (const double side : {-1.0, 1.0}) {
    // Centre: from the edge of the floor half the slope's length up, then half the thickness into the wall.
    const double out = half + along * run + t * rise, up = along * rise - t * run;
    scene.walls.push_back(
        {{along + t, wide, t}, {side * out, 0, up}, quat_from_rotation_vector(Vec3d{0, -side * kBowlSlope_rad, 0})});
    scene.walls.push_back(
        {{wide, along + t, t}, {0, side * out, up}, quat_from_rotation_vector(Vec3d{side * kBowlSlope_rad, 0, 0})});
  }
}

Cube cube_at(double edge_m, const Vec3d& at, Random& random) {
  const Vec3d shift = random.vector(kJitter * edge_m);
  return {.edge_m = edge_m,
          .mass_kg = kDensity * edge_m * edge_m * edge_m,
          .position = at + shift,
          .rotation = quat_from_rotation_vector(random.vector(kMaxTilt_rad))};
}

// Equal cubes on a square grid, layer upon layer. Returns the width of the box that holds them.
double place_equal(BoxScene& scene, const BoxPileSpec& spec, Random& random) {
  const double pitch = spec.smallest_edge_m * (1 + kGap);
  const std::uint32_t per_layer = (spec.cubes + spec.layers - 1) / spec.layers;
  std::uint32_t columns = 1;
  while (columns * columns < per_layer) ++columns;
  const double first = -0.5 * pitch * (columns - 1);
  for (std::uint32_t i = 0; i < spec.cubes; ++i) {
    const std::uint32_t x = i % columns, y = i / columns % columns, z = i / (columns * columns);
    scene.cubes.push_back(
        cube_at(spec.smallest_edge_m, {first + pitch * x, first + pitch * y, pitch * (z + 1)}, random));
  }
  return pitch * columns;
}

// Cubes of many sizes: the depth of rows and the height of layers follow from their largest cube.
double place_mixed(BoxScene& scene, const BoxPileSpec& spec, Random& random) {
  const double ratio = spec.largest_edge_m / spec.smallest_edge_m, shelf = spec.largest_edge_m * (1 + kGap);
  const double mean = (spec.largest_edge_m - spec.smallest_edge_m) / std::log(ratio) * (1 + kGap);
  const double width = std::max(2 * shelf, std::sqrt(spec.cubes * mean * shelf / spec.layers));
  double x = 0, y = 0, z = spec.largest_edge_m;
  for (std::uint32_t i = 0; i < spec.cubes; ++i) {
    const double edge = spec.smallest_edge_m * std::exp(std::log(ratio) * random.uniform());
    const double room = edge * (1 + kGap);
    if (x + room > width) {
      x = 0;
      y += shelf;
    }
    if (y + shelf > width) {
      y = 0;
      z += shelf;
    }
    scene.cubes.push_back(cube_at(edge, {x + 0.5 * room - 0.5 * width, y + 0.5 * shelf - 0.5 * width, z}, random));
    x += room;
  }
  return width;
}

// Boxes of 0.1 to 0.2 m on rough ground of 20,000 triangles, dropped on the inner part of it.
BoxScene make_rolling_boxes(std::string name, std::uint32_t boxes) {
  constexpr double kGravityTilt_rad = 0.61, kTurn_rad_per_s = 2, kPitch_m = 0.25, kDrop_m = 0.5, kWallHeight_m = 4;
  BoxScene scene;
  scene.name = std::move(name);
  const TerrainSpec spec;
  Random random(1);
  auto built = sim::build_mesh(sim::weld(make_terrain(spec, random)), physics::kFirstPatchId);
  TACTUS_CHECK(built.ok(), spec.cells, boxes);
  scene.terrain = std::move(built.value());
  scene.turning = TurningGravity{kGravityTilt_rad, kTurn_rad_per_s};
  std::uint32_t columns = 1;
  while (columns * columns < boxes) ++columns;
  const double first = -0.5 * kPitch_m * (columns - 1);
  for (std::uint32_t i = 0; i < boxes; ++i) {
    const double edge = 0.1 * std::exp(std::log(2.0) * random.uniform());
    scene.cubes.push_back(cube_at(
        edge, {first + kPitch_m * (i % columns), first + kPitch_m * (i / columns), 2 * spec.wave_m + kDrop_m}, random));
  }
  const double half = 0.5 * spec.cells * spec.cell_m, t = kWallHalf_m;
  for (const double side : {-1.0, 1.0}) {
    scene.walls.push_back({{t, half + 2 * t, kWallHeight_m}, {side * (half + t), 0, 0}});
    scene.walls.push_back({{half, t, kWallHeight_m}, {0, side * (half + t), 0}});
  }
  return scene;
}

struct Named {
  std::string_view name;
  BoxPileSpec spec;
  std::uint32_t timed_steps;
  bool terrain{false};
};

BoxPileSpec hulls(std::uint32_t vertices) {
  return {.cubes = 1000, .step_s = 1e-2, .forms = {Form::kHull}, .hull_vertices = vertices};
}

BoxPileSpec stirred(BoxPileSpec spec) {
  spec.stirred = true;
  return spec;
}

const std::vector<Named>& named_scenes() {
  static const BoxPileSpec kShapes{.cubes = 1000,
                                   .step_s = 1e-2,
                                   .smallest_edge_m = 0.05,
                                   .largest_edge_m = 0.2,
                                   .forms = {Form::kSphere, Form::kCapsule, Form::kPlate, Form::kHull}};
  // Name, pile, timed steps, on terrain.
  static const std::vector<Named> scenes{
      {"pile64", {.cubes = 64, .step_s = 1e-3}, 2000},
      {"pile64-stirred", {.cubes = 64, .step_s = 1e-3, .stirred = true}, 2000},
      {"pile1000", {.cubes = 1000, .step_s = 1e-2}, 300},
      {"pile1000-stirred", {.cubes = 1000, .step_s = 1e-2, .stirred = true}, 300},
      {"pile5000", {.cubes = 5000, .step_s = 1e-2}, 100},
      {"pile5000-stirred", {.cubes = 5000, .step_s = 1e-2, .stirred = true}, 100},
      {"pile10000", {.cubes = 10000, .step_s = 1e-2}, 60},
      {"pile10000-stirred", {.cubes = 10000, .step_s = 1e-2, .stirred = true}, 60},
      {"hulls1000", hulls(20), 300},
      {"hulls1000-stirred", stirred(hulls(20)), 300},
      {"hulls1000-8", hulls(8), 300},
      {"hulls1000-8-stirred", stirred(hulls(8)), 300},
      {"hulls1000-64", hulls(64), 100},
      {"hulls1000-64-stirred", stirred(hulls(64)), 100},
      {"shapes1000", kShapes, 300},
      {"shapes1000-stirred", stirred(kShapes), 300},
      {"terrain1000", {.cubes = 1000}, 300, true},
      {"mixed10000", {.cubes = 10000, .step_s = 1e-2, .smallest_edge_m = 0.02, .largest_edge_m = 0.4}, 60},
  };
  return scenes;
}

}  // namespace

std::uint32_t rods_of(const BoxScene& scene) noexcept {
  return scene.stirrer ? static_cast<std::uint32_t>(scene.stirrer->centres_m.size()) : 0;
}

BoxScene make_pile(std::string name, const BoxPileSpec& spec) {
  BoxScene scene;
  scene.name = std::move(name);
  scene.step_s = spec.step_s;
  Random random(spec.seed);
  const bool mixed = spec.largest_edge_m > spec.smallest_edge_m;
  const double width = mixed ? place_mixed(scene, spec, random) : place_equal(scene, spec, random);
  if (!spec.forms.empty()) give_forms(scene, spec);
  double top = 0;
  for (const Cube& cube : scene.cubes) top = std::max(top, cube.position.z + cube.edge_m);
  if (spec.stirred) {
    // The heap starts above the rods; the box is enlarged for the rods.
    const double edge = spec.largest_edge_m;
    scene.stirrer = make_stirrer(spec.cubes, edge);
    const double rise = scene.stirrer->centres_m.front().z + scene.stirrer->half_extents_m.z + edge;
    for (Cube& cube : scene.cubes) cube.position.z += rise;
    add_bowl(scene, floor_width(*scene.stirrer, edge), top + rise);
  } else {
    add_walls(scene, width, top + 1);
  }
  return scene;
}

const std::vector<std::string_view>& scene_names() {
  static const std::vector<std::string_view> names = [] {
    std::vector<std::string_view> all;
    for (const Named& named : named_scenes()) all.push_back(named.name);
    return all;
  }();
  return names;
}

std::optional<BoxScene> make_scene(std::string_view name, bool quick) {
  for (const Named& named : named_scenes()) {
    if (named.name != name) continue;
    BoxScene scene = named.terrain ? make_rolling_boxes(std::string(name), named.spec.cubes)
                                   : make_pile(std::string(name), named.spec);
    scene.timed_steps = quick ? named.timed_steps / 5 : named.timed_steps;
    if (quick) scene.settle_s = 1;
    return scene;
  }
  return std::nullopt;
}

}  // namespace tactus::experiment
