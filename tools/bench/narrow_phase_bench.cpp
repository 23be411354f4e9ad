// Cost of finding the contact of two boxes, by their relative pose, with and without the axis cache of the last step.
#include <benchmark/benchmark.h>

#include "rt/base/denormals.h"
#include "rt/physics/collision/manifold.h"

namespace tactus::bench {
namespace {

enum Lie : int { kFace, kTurnedFace, kEdges, kApart };

// Two unit boxes, one above the other.
Posed upper_pose(int lie) {
  switch (lie) {
    case kTurnedFace:
      return {{0.1, 0.2, 0.999}, quat_from_rotation_vector(Vec3d{0.0, 0.0, 0.4})};
    case kEdges:
      return {{0.0, 0.0, 1.41}, quat_from_rotation_vector(Vec3d{0.0, 0.78, 0.0})};
    case kApart:
      return {{0.1, 0.2, 1.2}, {}};
    default:
      return {{0.1, 0.2, 0.999}, {}};
  }
}

Posed lower_pose(int lie) {
  if (lie == kEdges) return {{}, quat_from_rotation_vector(Vec3d{0.78, 0.0, 0.0})};
  return {};
}

void boxes_collide(benchmark::State& state) {
  set_denormals_flush();
  const auto lie = static_cast<int>(state.range(0));
  const bool remembers = state.range(1) != 0;
  const auto box = physics::Shape::box({0.5, 0.5, 0.5});
  Posed lower = lower_pose(lie), upper = upper_pose(lie);
  physics::AxisCache cache;
  std::uint32_t points = 0;
  for (auto _ : state) {
    if (!remembers) cache = {};
    benchmark::DoNotOptimize(lower);
    benchmark::DoNotOptimize(upper);
    const auto manifold = physics::collide({box, lower}, {box, upper}, {.margin = 0.01}, cache);
    points = manifold.count;
    benchmark::DoNotOptimize(points);
  }
  state.counters["points"] = points;
}

void lies(benchmark::internal::Benchmark* b) {
  b->ArgNames({"lie", "remembers"});
  for (const int lie : {kFace, kTurnedFace, kEdges, kApart})
    for (const int remembers : {0, 1}) b->Args({lie, remembers});
}
BENCHMARK(boxes_collide)->Apply(lies);

}  // namespace
}  // namespace tactus::bench
