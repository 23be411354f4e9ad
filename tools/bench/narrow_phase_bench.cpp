// Where two boxes touch: by how they lie, with what the step before remembered of the pair and without.
#include <benchmark/benchmark.h>

#include "rt/base/denormals.h"
#include "rt/physics/collision/manifold.h"

namespace tactus::bench {
namespace {

enum Lie : int { kFace, kTurnedFace, kEdges, kApart };

// Two unit boxes, one above the other.
template <class T>
Pose<T> upper_pose(int lie) {
  switch (lie) {
    case kTurnedFace:
      return {{T(0.1), T(0.2), T(0.999)}, quat_from_rotation_vector(Vec3<T>{T(0), T(0), T(0.4)})};
    case kEdges:
      return {{T(0), T(0), T(1.41)}, quat_from_rotation_vector(Vec3<T>{T(0), T(0.78), T(0)})};
    case kApart:
      return {{T(0.1), T(0.2), T(1.2)}, {}};
    default:
      return {{T(0.1), T(0.2), T(0.999)}, {}};
  }
}

template <class T>
Pose<T> lower_pose(int lie) {
  if (lie == kEdges) return {{}, quat_from_rotation_vector(Vec3<T>{T(0.78), T(0), T(0)})};
  return {};
}

template <class T>
void boxes_collide(benchmark::State& state) {
  set_denormals_flush();
  const auto lie = static_cast<int>(state.range(0));
  const bool remembers = state.range(1) != 0;
  const auto box = physics::Shape<T>::box({T(0.5), T(0.5), T(0.5)});
  Pose<T> lower = lower_pose<T>(lie), upper = upper_pose<T>(lie);
  physics::AxisCache cache;
  std::uint32_t points = 0;
  for (auto _ : state) {
    if (!remembers) cache = {};
    benchmark::DoNotOptimize(lower), benchmark::DoNotOptimize(upper);
    const auto manifold = physics::collide(box, lower, box, upper, T(0.01), cache);
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
BENCHMARK_TEMPLATE(boxes_collide, double)->Apply(lies);
BENCHMARK_TEMPLATE(boxes_collide, float)->Apply(lies);

}  // namespace
}  // namespace tactus::bench
