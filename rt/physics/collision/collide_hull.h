// The pair kernels of hulls. Inside narrow phase; as the kernels of collide.h, plus views of the pair's hulls. A box is
// treated as a hull. Thread: [any]; pure, bounded, no allocation.
#pragma once

#include "rt/physics/collision/collide.h"
#include "rt/physics/shapes/hull_view.h"

namespace tactus::physics {

// Axis codes of AxisCache after those of boxes: a face of A, a face of B, an edge of A x an edge of B.
inline constexpr std::uint8_t kHullFaceA = kFirstHullAxis, kHullFaceB = kFirstHullAxis + 1,
                              kHullEdges = kFirstHullAxis + 2;

void collide_hulls(const PairView& pair, const HullView& a, const HullView& b, Manifold& manifold,
                   AxisCache& cache) noexcept;
// A is the plane, or the round shape; B the hull.
void collide_plane_hull(const PairView& pair, const HullView& hull, Manifold& manifold) noexcept;
void collide_sphere_hull(const PairView& pair, const HullView& hull, Manifold& manifold) noexcept;
void collide_capsule_hull(const PairView& pair, const HullView& hull, Manifold& manifold) noexcept;

}  // namespace tactus::physics
