#include "rt/physics/collision/collide_mesh.h"

#include "rt/physics/collision/collide_cylinder.h"

namespace tactus::physics {

Manifold collide_patch(PosedShape a, const PosedPatch& patch, const ManifoldQuery& query, Hulls hulls) noexcept {
  Manifold manifold;
  const Shape none;  // placeholder: the kernels read the mesh, not its shape
  const PairView pair = pair_view(a, {.shape = none, .pose = patch.world_from_mesh}, query);
  const PatchView view{.pair = pair,
                       .mesh = patch.mesh,
                       .triangles = patch.triangles,
                       .centre = rotate_inverse(pair.world_from_b, -pair.b_from_a)};
  switch (a.shape.kind) {
    case ShapeKind::kSphere:
      collide_sphere_patch(view, manifold);
      break;
    case ShapeKind::kCapsule:
      collide_capsule_patch(view, manifold);
      break;
    case ShapeKind::kBox:
      collide_hull_patch(view, BoxHull(a.shape.half_extents).view(), manifold);
      break;
    case ShapeKind::kHull:
      if (a.shape.index < hulls.size()) collide_hull_patch(view, view_of(hulls[a.shape.index]), manifold);
      break;
    case ShapeKind::kCylinder:
    case ShapeKind::kCone:
      collide_cylinder_patch(view, manifold);
      break;
    case ShapeKind::kPlane:
    case ShapeKind::kMesh:
    case ShapeKind::kCompound:
      break;
  }
  return manifold;
}

}  // namespace tactus::physics
