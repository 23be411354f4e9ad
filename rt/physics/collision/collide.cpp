// The dispatcher of narrow phase: orders the two shapes by kind, calls the kernel, mirrors the result if it swapped
// them.
#include "rt/physics/collision/collide.h"

#include <utility>

#include "rt/physics/collision/collide_cylinder.h"
#include "rt/physics/collision/collide_hull.h"

namespace tactus::physics {
namespace {

// In the functions below the name says what B is; A is any shape.
void collide_with_hull(const PairView& pair, Manifold& manifold, AxisCache& cache, Hulls hulls) noexcept {
  if (pair.b.index >= hulls.size()) return;
  const HullView hull = view_of(hulls[pair.b.index]);
  switch (pair.a.kind) {
    case ShapeKind::kSphere:
      return collide_sphere_hull(pair, hull, manifold);
    case ShapeKind::kCapsule:
      return collide_capsule_hull(pair, hull, manifold);
    case ShapeKind::kBox:
      return collide_hulls(pair, BoxHull(pair.a.half_extents).view(), hull, manifold, cache);
    case ShapeKind::kPlane:
      return collide_plane_hull(pair, hull, manifold);
    case ShapeKind::kHull:
      if (pair.a.index < hulls.size()) collide_hulls(pair, view_of(hulls[pair.a.index]), hull, manifold, cache);
      return;
    case ShapeKind::kMesh:
    case ShapeKind::kCompound:
    case ShapeKind::kCylinder:  // ordered behind hulls
    case ShapeKind::kCone:
      return;
  }
}

void collide_with_box(const PairView& pair, Manifold& manifold, AxisCache& cache) noexcept {
  switch (pair.a.kind) {
    case ShapeKind::kSphere:
      return collide_sphere_box(pair, manifold);
    case ShapeKind::kCapsule:
      return collide_capsule_box(pair, manifold);
    case ShapeKind::kBox:
      return collide_box_box(pair, manifold, cache);
    case ShapeKind::kPlane:  // ordered behind boxes, as all below
    case ShapeKind::kHull:
    case ShapeKind::kMesh:
    case ShapeKind::kCompound:
    case ShapeKind::kCylinder:
    case ShapeKind::kCone:
      return;
  }
}

void collide_with_plane(const PairView& pair, Manifold& manifold) noexcept {
  switch (pair.a.kind) {
    case ShapeKind::kSphere:
      return collide_sphere_plane(pair, manifold);
    case ShapeKind::kCapsule:
      return collide_capsule_plane(pair, manifold);
    case ShapeKind::kBox:
      return collide_box_plane(pair, manifold);
    case ShapeKind::kPlane:  // neither moves
    case ShapeKind::kHull:   // ordered behind planes, as all below
    case ShapeKind::kMesh:
    case ShapeKind::kCompound:
    case ShapeKind::kCylinder:
    case ShapeKind::kCone:
      return;
  }
}

// A is of the same kind as B or of one before it.
void collide_ordered(const PairView& pair, Manifold& manifold, AxisCache& cache, Hulls hulls) noexcept {
  switch (pair.b.kind) {
    case ShapeKind::kSphere:
      return collide_sphere_sphere(pair, manifold);
    case ShapeKind::kCapsule:
      return pair.a.kind == ShapeKind::kSphere ? collide_sphere_capsule(pair, manifold)
                                               : collide_capsule_capsule(pair, manifold);
    case ShapeKind::kBox:
      return collide_with_box(pair, manifold, cache);
    case ShapeKind::kPlane:
      return collide_with_plane(pair, manifold);
    case ShapeKind::kHull:
      return collide_with_hull(pair, manifold, cache, hulls);
    case ShapeKind::kCylinder:
    case ShapeKind::kCone:
      return collide_with_cylinder(pair, manifold, cache, hulls);
    case ShapeKind::kMesh:      // collide_mesh.h
    case ShapeKind::kCompound:  // collide_parts.h
      return;
  }
}

}  // namespace

Manifold collide(PosedShape a, PosedShape b, const ManifoldQuery& query, AxisCache& cache, Hulls hulls) noexcept {
  Manifold manifold;
  if (a.shape.kind <= b.shape.kind) {
    collide_ordered(pair_view(a, b, query), manifold, cache, hulls);
    return manifold;
  }
  collide_ordered(pair_view(b, a, query), manifold, cache, hulls);
  manifold.normal = -manifold.normal;
  for (std::uint32_t i = 0; i < manifold.count; ++i) std::swap(manifold.points[i].from_a, manifold.points[i].from_b);
  return manifold;
}

}  // namespace tactus::physics
