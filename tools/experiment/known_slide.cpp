#include "tools/experiment/known_slide.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "rt/base/check.h"

namespace tactus::experiment {
namespace {

constexpr double kTilt_rad = 0.61;
constexpr double kFriction = 0.3;
constexpr double kEdge_m =
    0.25;  // of a box: on three or four ridges, one of them far enough ahead that it does not tip
constexpr double kShort_m = 0.04;  // of a cell of the ground, across the ridges; a ridge every two cells
constexpr double kLong_m = 0.5;    // along them
constexpr double kRidge_m = 0.02;  // height
constexpr double kHalf_m = 3;      // of the ground

sim::TriangleSoup ground_of(SlideGround ground) {
  const bool along = ground == SlideGround::kRidgesAlong;
  const double x_cell_m = along ? kLong_m : kShort_m, y_cell_m = along ? kShort_m : kLong_m;
  const auto x_cells = static_cast<std::uint32_t>(std::lround(2 * kHalf_m / x_cell_m));
  const auto y_cells = static_cast<std::uint32_t>(std::lround(2 * kHalf_m / y_cell_m));
  sim::TriangleSoup soup;
  for (std::uint32_t j = 0; j <= y_cells; ++j) {
    for (std::uint32_t i = 0; i <= x_cells; ++i) {
      const bool valley = ground != SlideGround::kFlat && (along ? j : i) % 2 == 1;
      soup.corners.push_back({i * x_cell_m - kHalf_m, j * y_cell_m - kHalf_m, valley ? -kRidge_m : 0.0});
    }
  }
  add_grid_triangles(x_cells, y_cells, soup);
  return soup;
}

constexpr std::pair<SlideGround, std::string_view> kGrounds[] = {{SlideGround::kFlat, "flat"},
                                                                 {SlideGround::kRidgesAcross, "ridges across"},
                                                                 {SlideGround::kRidgesAlong, "ridges along"}};

}  // namespace

BoxScene make_slide(SlideGround ground) {
  constexpr double kPitch_m = 0.6, kShift_m = 0.013;  // the shift: each box begins elsewhere on the ridges
  BoxScene scene;
  scene.name = "slide";
  scene.friction = kFriction;
  scene.settle_s = 1;
  auto built = sim::build_mesh(sim::weld(ground_of(ground)), physics::kFirstPatchId);
  TACTUS_CHECK(built.ok(), static_cast<std::uint32_t>(ground), 0);
  scene.terrain = std::move(built.value());
  scene.turning = TurningGravity{.tilt_rad = kTilt_rad, .speed_rad_per_s = 0};
  for (int i = 0; i < 9; ++i) {
    const double x = -2 + kPitch_m * (i % 3) + kShift_m * i, y = kPitch_m * (i / 3 - 1) + kShift_m * i;
    scene.cubes.push_back({.edge_m = kEdge_m,
                           .mass_kg = 1000 * kEdge_m * kEdge_m * kEdge_m,
                           .position = {x, y, 0.5 * kEdge_m},
                           .rotation = quat_from_rotation_vector(Vec3d{0, 0, 0.35 * (i % 3)})});
  }
  return scene;
}

SlideError slide_error(const EngineKind& kind, EngineOptions options) {
  options.tuned = kind.tuned;
  options.iterations = kind.iterations;
  SlideError worst;
  for (const auto& [ground, name] : kGrounds) {
    const BoxScene scene = make_slide(ground);
    const auto engine = kind.make(scene, options);
    const auto steps = static_cast<std::uint32_t>(std::lround(scene.settle_s / scene.step_s));
    for (std::uint32_t i = 0; i < steps; ++i) engine->step();
    const SinCos tilt = sin_cos(kTilt_rad);
    const double a = scene.gravity_m_per_s2 * (tilt.sin - scene.friction * tilt.cos);
    const double way = 0.5 * a * scene.settle_s * (scene.settle_s + scene.step_s);
    if (!engine->failure().empty()) return {std::numeric_limits<double>::infinity(), name};
    const auto cubes = engine->cubes();
    for (std::size_t i = 0; i < cubes.size(); ++i) {
      const Vec3d moved = cubes[i].position - scene.cubes[i].position;
      const double share = norm(moved - Vec3d{way, 0, 0}) / way;
      if (!(share <= worst.share)) worst = {share, name};  // or NaN
    }
  }
  return worst;
}

}  // namespace tactus::experiment
