#include "rt/physics/collision/collide_mesh.h"

namespace tactus::physics {

template <class T>
Manifold<T> collide_patch(const Shape<T>& a, const Pose<T>& world_from_a, const Pose<T>& world_from_mesh,
                          const Mesh<T>& mesh, std::span<const std::uint32_t> triangles, T margin,
                          std::type_identity_t<Hulls<T>> hulls, const LastFeatures& last) noexcept {
  Manifold<T> manifold;
  const Shape<T> none;  // the kernels look at the mesh, not at its shape
  const PairView<T> pair{
      a,      none, world_from_a.rotation, world_from_mesh.rotation, world_from_mesh.position - world_from_a.position,
      margin, last};
  const PatchView<T> patch{pair, mesh, triangles, rotate_inverse(world_from_mesh.rotation, -pair.b_from_a)};
  switch (a.kind) {
    case ShapeKind::kSphere:
      collide_sphere_patch(patch, manifold);
      break;
    case ShapeKind::kCapsule:
      collide_capsule_patch(patch, manifold);
      break;
    case ShapeKind::kBox:
      collide_hull_patch(patch, BoxHull<T>(a.half_extents).view(), manifold);
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

template Manifold<double> collide_patch<double>(const Shape<double>&, const Pose<double>&, const Pose<double>&,
                                                const Mesh<double>&, std::span<const std::uint32_t>, double,
                                                Hulls<double>, const LastFeatures&) noexcept;
template Manifold<float> collide_patch<float>(const Shape<float>&, const Pose<float>&, const Pose<float>&,
                                              const Mesh<float>&, std::span<const std::uint32_t>, float, Hulls<float>,
                                              const LastFeatures&) noexcept;

}  // namespace tactus::physics
