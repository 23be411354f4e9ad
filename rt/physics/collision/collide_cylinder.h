// The kernels of cylinders and cones: each turns its polygon to the other body and is then a hull (round_hull.h).
// Inside narrow phase. Thread: [any]; pure, bounded, no allocation.
#pragma once

#include "rt/physics/collision/collide.h"
#include "rt/physics/collision/collide_mesh.h"
#include "rt/physics/shapes/round_hull.h"

namespace tactus::physics {

// B is a cylinder or a cone; A any shape but a mesh or a compound.
void collide_with_cylinder(const PairView& pair, Manifold& manifold, AxisCache& cache, Hulls hulls) noexcept;
// A, the body of `pair`, is a cylinder or a cone.
void collide_cylinder_patch(const PatchView& patch, Manifold& manifold) noexcept;

}  // namespace tactus::physics
