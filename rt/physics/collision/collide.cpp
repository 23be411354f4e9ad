// The dispatcher of narrow phase: orders the two shapes by kind, calls the kernel, mirrors the result if it swapped
// them.
#include "rt/physics/collision/collide.h"

#include <utility>

#include "rt/physics/collision/collide_cylinder.h"
#include "rt/physics/collision/collide_hull.h"

namespace tactus::physics {
namespace {

constexpr std::uint32_t pair_of(ShapeKind a, ShapeKind b) noexcept {
  return static_cast<std::uint32_t>(a) * 16 + static_cast<std::uint32_t>(b);
}

// B is a hull, A any shape.
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

void collide_ordered(const PairView& pair, Manifold& manifold, AxisCache& cache, Hulls hulls) noexcept {
  using enum ShapeKind;
  switch (pair_of(pair.a.kind, pair.b.kind)) {
    case pair_of(kSphere, kSphere):
      return collide_sphere_sphere(pair, manifold);
    case pair_of(kSphere, kCapsule):
      return collide_sphere_capsule(pair, manifold);
    case pair_of(kSphere, kBox):
      return collide_sphere_box(pair, manifold);
    case pair_of(kSphere, kPlane):
      return collide_sphere_plane(pair, manifold);
    case pair_of(kCapsule, kCapsule):
      return collide_capsule_capsule(pair, manifold);
    case pair_of(kCapsule, kBox):
      return collide_capsule_box(pair, manifold);
    case pair_of(kCapsule, kPlane):
      return collide_capsule_plane(pair, manifold);
    case pair_of(kBox, kBox):
      return collide_box_box(pair, manifold, cache);
    case pair_of(kBox, kPlane):
      return collide_box_plane(pair, manifold);
    default:
      if (pair.b.kind == kHull) collide_with_hull(pair, manifold, cache, hulls);
      if (pair.b.kind == kCylinder || pair.b.kind == kCone) collide_with_cylinder(pair, manifold, cache, hulls);
      return;  // or two planes; or a mesh (collide_mesh.h) or a compound (collide_parts.h)
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
