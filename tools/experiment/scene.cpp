#include "tools/experiment/scene.h"

#include <algorithm>
#include <cmath>

#include "sim/random.h"

namespace tactus::experiment {
namespace {

constexpr double kDensity = 1000;  // kg/m^3
// Room enough for tilted cubes, and for a heap rather than columns.
constexpr double kGap = 0.4;         // of the edge, between neighbours of the grid
constexpr double kJitter = 0.05;     // of the edge, to either side: less than the gap lets them meet
constexpr double kTilt_rad = 0.3;    // about each axis, at most
constexpr double kWallHalf_m = 0.5;  // thick enough that nothing gets through

using sim::Random;

void add_walls(BoxScene& scene, double width_m, double height_m) {
  const double half = 0.5 * width_m, t = kWallHalf_m, tall = 0.5 * height_m, out = half + 2 * t;
  scene.walls.push_back({{out, out, t}, {0, 0, -t}});
  for (const double side : {-1.0, 1.0}) {
    scene.walls.push_back({{t, out, tall}, {side * (half + t), 0, tall}});
    scene.walls.push_back({{half, t, tall}, {0, side * (half + t), tall}});
  }
}

Cube cube_at(double edge_m, const Vec3d& at, Random& random) {
  const Vec3d shift = random.vector(kJitter * edge_m);
  return {edge_m, kDensity * edge_m * edge_m * edge_m, at + shift, quat_from_rotation_vector(random.vector(kTilt_rad))};
}

// Equal cubes on a square grid, layer upon layer. Returns the width of the box that holds them.
double place_equal(BoxScene& scene, const PileSpec& spec, Random& random) {
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

// Cubes of many sizes: rows as deep and layers as high as the largest of them needs.
double place_mixed(BoxScene& scene, const PileSpec& spec, Random& random) {
  const double ratio = spec.largest_edge_m / spec.smallest_edge_m, shelf = spec.largest_edge_m * (1 + kGap);
  const double mean = (spec.largest_edge_m - spec.smallest_edge_m) / std::log(ratio) * (1 + kGap);
  const double width = std::max(2 * shelf, std::sqrt(spec.cubes * mean * shelf / spec.layers));
  double x = 0, y = 0, z = spec.largest_edge_m;
  for (std::uint32_t i = 0; i < spec.cubes; ++i) {
    const double edge = spec.smallest_edge_m * std::exp(std::log(ratio) * random.uniform());
    const double room = edge * (1 + kGap);
    if (x + room > width) x = 0, y += shelf;
    if (y + shelf > width) y = 0, z += shelf;
    scene.cubes.push_back(cube_at(edge, {x + 0.5 * room - 0.5 * width, y + 0.5 * shelf - 0.5 * width, z}, random));
    x += room;
  }
  return width;
}

struct Named {
  std::string_view name;
  PileSpec spec;
  std::uint32_t timed_steps;
};

const std::vector<Named>& named_scenes() {
  static const std::vector<Named> scenes{
      {"pile64", {.cubes = 64, .step_s = 1e-3}, 2000},
      {"pile64-stirred", {.cubes = 64, .step_s = 1e-3, .stirred = true}, 2000},
      {"pile1000", {.cubes = 1000, .step_s = 1e-2}, 300},
      {"pile5000", {.cubes = 5000, .step_s = 1e-2}, 100},
      {"pile10000", {.cubes = 10000, .step_s = 1e-2}, 60},
      {"mixed10000", {.cubes = 10000, .step_s = 1e-2, .smallest_edge_m = 0.02, .largest_edge_m = 0.4}, 60},
  };
  return scenes;
}

}  // namespace

Vec3d Paddle::position_at(double time_s) const noexcept {
  const double angle = speed_rad_per_s * time_s;
  return {radius_m * std::cos(angle), radius_m * std::sin(angle), height_m};
}

Vec3d Paddle::velocity_at(double time_s) const noexcept {
  const double angle = speed_rad_per_s * time_s, speed = radius_m * speed_rad_per_s;
  return {-speed * std::sin(angle), speed * std::cos(angle), 0};
}

BoxScene make_pile(std::string name, const PileSpec& spec) {
  BoxScene scene;
  scene.name = std::move(name);
  scene.step_s = spec.step_s;
  Random random(spec.seed);
  const bool mixed = spec.largest_edge_m > spec.smallest_edge_m;
  double width = mixed ? place_mixed(scene, spec, random) : place_equal(scene, spec, random);
  double top = 0;
  for (const Cube& cube : scene.cubes) top = std::max(top, cube.position.z + cube.edge_m);
  if (spec.stirred) {
    // The heap starts above the rod, and the rod needs room of its own.
    const double edge = spec.largest_edge_m, rod_half = 2 * edge;
    width += edge;
    for (Cube& cube : scene.cubes) cube.position.z += 2 * rod_half + edge;
    top += 2 * rod_half + edge;
    scene.paddle = Paddle{{0.25 * edge, 0.25 * edge, rod_half}, rod_half + 0.2 * edge, 0.25 * width, 2.0};
  }
  add_walls(scene, width, top + 1);
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
    BoxScene scene = make_pile(std::string(name), named.spec);
    scene.timed_steps = quick ? named.timed_steps / 5 : named.timed_steps;
    if (quick) scene.settle_s = 1;
    return scene;
  }
  return std::nullopt;
}

}  // namespace tactus::experiment
