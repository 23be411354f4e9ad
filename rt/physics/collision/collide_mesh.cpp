#include "rt/physics/collision/collide_mesh.h"

namespace tactus::physics {

Manifold collide_patch(const Shape& a, const Posed& world_from_a, const Posed& world_from_mesh, const Mesh& mesh,
                       std::span<const std::uint32_t> triangles, double margin, std::type_identity_t<Hulls> hulls,
                       const LastFeatures& last) noexcept {
  Manifold manifold;
  const Shape none;  // placeholder: the kernels read the mesh, not its shape
  const PairView pair{
      a,      none, world_from_a.rotation, world_from_mesh.rotation, world_from_mesh.position - world_from_a.position,
      margin, last};
  const PatchView patch{pair, mesh, triangles, rotate_inverse(world_from_mesh.rotation, -pair.b_from_a)};
  switch (a.kind) {
    case ShapeKind::kSphere:
      collide_sphere_patch(patch, manifold);
      break;
    case ShapeKind::kCapsule:
      collide_capsule_patch(patch, manifold);
      break;
    case ShapeKind::kBox:
      collide_hull_patch(patch, BoxHull(a.half_extents).view(), manifold);
      break;
    case ShapeKind::kHull:
      if (a.index < hulls.size()) collide_hull_patch(patch, view_of(hulls[a.index]), manifold);
      break;
    case ShapeKind::kPlane:
    case ShapeKind::kMesh:
      break;
  }
  return manifold;
}

}  // namespace tactus::physics
