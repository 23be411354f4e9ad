// Narrow phase of several pairs of boxes at once: the axes of four pairs are tested together (box_axes.h).
// Frame: world. Units: m. Thread: [any]; pure, no allocation.
#pragma once

#include <span>

#include "rt/physics/collision/collide.h"

namespace tactus::physics {

inline constexpr std::uint32_t kBoxPairs = 4;  // pairs at once

// Two boxes: `frame_a` and `frame_b` are those of their poses.
struct BoxPairQuery {
  PosedShape a, b;
  const BodyFrame &frame_a, &frame_b;
  const ManifoldQuery& query;
  AxisCache& cache;
  Manifold& manifold;  // result
};

// The same manifolds, bit by bit, as `collide` for each pair. From 1 to kBoxPairs pairs.
void collide_boxes(std::span<const BoxPairQuery> pairs) noexcept;

}  // namespace tactus::physics
