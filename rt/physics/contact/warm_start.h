// Impulses of a contact from another world, so that a body that moves between worlds keeps its warm start.
//
// In newtons (impulse / sub-step), because the two worlds' sub-steps differ. Frame: world. Thread: [any], a plain
// value.
#pragma once

#include "rt/base/ids.h"
#include "rt/physics/collision/manifold.h"

namespace tactus::physics {

struct WarmStart {
  PairKey key;
  AxisCache axis_cache;
  std::uint8_t padding{0};
  std::uint32_t count{0};
  std::array<std::uint32_t, kMaxManifoldPoints> features{};
  std::array<double, kMaxManifoldPoints> normal_force{};   // N
  std::array<Vec3d, kMaxManifoldPoints> friction_force{};  // N, on B, world
};
static_assert(sizeof(WarmStart) == 8 + 3 + 1 + 4 + kMaxManifoldPoints * (4 + 8 + 24),
              "no padding: a snapshot goes to the tape byte by byte");

}  // namespace tactus::physics
