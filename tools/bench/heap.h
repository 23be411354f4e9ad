// A settled heap of equal cubes, for the benchmarks of the kernels. Thread: one. Units: SI.
#pragma once

#include <cmath>

#include "rt/base/denormals.h"
#include "rt/physics/world.h"
#include "sim/broad_phase/pair_cache.h"

namespace tactus::bench {

inline constexpr double kEdge_m = 0.1;

// `cubes` cubes of 0.1 m, 1 kg on the ground, in layers of brick-like offsets, after half a second.
struct Heap {
  physics::World world;
  physics::StepSettings settings;
  sim::PairCache pair_cache;
  physics::StepReport report;

  explicit Heap(std::uint32_t cubes, physics::SweepPrecision precision = physics::SweepPrecision::kFull)
      : world({.bodies = cubes, .fixed_bodies = 1, .pairs = 16 * cubes + 256, .contacts = 8 * cubes + 256}, {}, {},
              precision),
        pair_cache(cubes, 16 * cubes + 256) {
    set_denormals_flush();
    settings.gravity = {0.0, 0.0, -9.81};
    const auto side = static_cast<std::uint32_t>(std::ceil(std::cbrt(static_cast<double>(cubes))));
    const double half = 0.5 * kEdge_m;
    for (std::uint32_t i = 0; i < cubes; ++i) {
      const std::uint32_t z = i / (side * side);
      const double shift = z % 2 == 1 ? half : 0.0, pitch = 1.02 * kEdge_m;
      const Vec3d at{pitch * static_cast<double>(i % side) + shift,
                     pitch * static_cast<double>(i / side % side) + shift, half + 2.0 * half * static_cast<double>(z)};
      static_cast<void>(
          world.insert(physics::make_dynamic_body(i, physics::Shape::box({half, half, half}), 1.0, 0.5, {at, {}})));
    }
    static_cast<void>(world.insert(physics::make_fixed_body(cubes, physics::Shape::plane(), 0.5, {})));
    for (int i = 0; i < 500; ++i) step();
  }

  void step() {
    world.begin_step(settings);
    static_cast<void>(pair_cache.find(world.bounds(), world.dynamic_pairs()));
    report = world.finish_step(settings);
  }
};

}  // namespace tactus::bench
