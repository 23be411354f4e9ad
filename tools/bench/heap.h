// A settled heap of equal cubes, for the benchmarks of the kernels. Thread: one. Units: SI.
#pragma once

#include <cmath>

#include "rt/base/denormals.h"
#include "rt/physics/world.h"
#include "sim/pair_cache.h"

namespace tactus::bench {

inline constexpr double kEdge_m = 0.1;

// `cubes` cubes of 0.1 m, 1 kg on the ground, in layers of brick-like offsets, after half a second.
template <class T>
struct Heap {
  physics::World<T> world;
  physics::StepSettings<T> settings;
  sim::PairCache pair_cache;
  physics::StepReport<T> report;

  explicit Heap(std::uint32_t cubes)
      : world({cubes, 1, 16 * cubes + 256, 8 * cubes + 256, 0}), pair_cache(cubes, 16 * cubes + 256) {
    set_denormals_flush();
    settings.gravity = {T(0), T(0), T(-9.81)};
    const auto side = static_cast<std::uint32_t>(std::ceil(std::cbrt(static_cast<double>(cubes))));
    const T half = T(0.5 * kEdge_m);
    for (std::uint32_t i = 0; i < cubes; ++i) {
      const std::uint32_t z = i / (side * side);
      const T shift = z % 2 == 1 ? half : T(0), pitch = T(1.02 * kEdge_m);
      const Vec3<T> at{pitch * static_cast<T>(i % side) + shift, pitch * static_cast<T>(i / side % side) + shift,
                       half + T(2) * half * static_cast<T>(z)};
      static_cast<void>(world.insert(
          physics::make_dynamic_body<T>(i, physics::Shape<T>::box({half, half, half}), T(1), T(0.5), {at, {}})));
    }
    static_cast<void>(world.insert(physics::make_fixed_body<T>(cubes, physics::Shape<T>::plane(), T(0.5), {})));
    for (int i = 0; i < 500; ++i) step();
  }

  void step() {
    world.begin_step(settings);
    static_cast<void>(pair_cache.find(world.bounds(), world.dynamic_pairs()));
    report = world.finish_step(settings);
  }
};

}  // namespace tactus::bench
