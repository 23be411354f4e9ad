// Which triangles of a mesh can a body touch in this step? Excludes those whose box overlaps the body's box and that
// the body cannot touch: by the triangle's patch plane and, for a body with faces, by the axes of the box that holds
// it.
//
// Frame: the mesh's. Units: m. Thread: [any]; pure. Bound: constant for each triangle.
#pragma once

#include "rt/base/wide.h"
#include "rt/physics/body_frame.h"
#include "rt/physics/collision/manifold.h"
#include "rt/physics/collision/motion_bound.h"
#include "rt/physics/shapes/compound.h"
#include "rt/physics/shapes/hull_view.h"
#include "rt/physics/shapes/mesh.h"

namespace tactus::physics {

// A body may be near many patches of a mesh and touch few: patches that cannot be touched in this step are dropped at
// this smaller margin [m]. On rolling ground a box as wide as two cells then has a third of the contacts (at 0.5 mm: 13
// patches).
inline constexpr double kPatchMargin = 5e-5;

// Points with a patch are wanted up to this separation [m], if the step may take `closing` from it.
inline double patch_margin(double closing, const StepSettings& settings) noexcept {
  return larger(smaller(kPatchMargin, settings.min_margin), closing + carry_over_margin(settings));
}

class MeshCulling {
 public:
  // `part`: of the body, in the mesh's frame. `bound`: of the body's motion, in the world.
  MeshCulling(const Mesh& mesh, const PosedPart& part, const MotionBound& bound, const Quatd& world_from_mesh,
              const StepSettings& settings, Hulls hulls) noexcept
      : mesh_(mesh),
        shape_(part.shape),
        settings_(settings),
        axes_(axes_of(part.pose.rotation)),
        centre_(part.pose.position),
        from_body_(part.from_body),
        bound_(bound),
        hull_(part.shape.kind == ShapeKind::kHull ? &hulls[part.shape.index] : nullptr) {
    bound_.advance = rotate_inverse(world_from_mesh, bound.advance);
    bound_.turn = rotate_inverse(world_from_mesh, bound.turn);
    for (int i = 0; i < 3 && has_faces(); ++i) {
      const Vec3d& axis = i == 0 ? axes_.x : i == 1 ? axes_.y : axes_.z;
      const Vec3d lever = cross(axis, bound_.turn);  // a point r moves along the axis by r . lever
      const double centre = dot(from_body_, lever), corner = dot(abs(to_part(lever)), shape_.half_extents);
      lowest_[i] = -shape_.half_extents[i] - margin_along(-axis, corner - centre);
      highest_[i] = shape_.half_extents[i] + margin_along(axis, corner + centre);
    }
  }

  bool can_touch(std::uint32_t triangle) const noexcept {
    const MeshTriangle& t = mesh_.triangles[triangle];
    const MeshPatch& patch = mesh_.patches[t.patch];
    const double height = dot(patch.normal, centre_) - patch.offset;
    // A body whose centre is behind the patch is not in contact with it; of a capsule, only a part need be in front.
    if (!(height > 0.0) && shape_.kind != ShapeKind::kCapsule) return false;
    // The patch's corners are at most kFlat from its plane.
    if (height - reach_along(-patch.normal) > kFlat) return false;
    return !has_faces() || overlaps_across_faces(t);
  }

 private:
  static constexpr double kFlat = 1e-5;

  // Separation along the unit vector d up to which points are wanted [m]. `by_turn`: see closing_to_fixed.
  double margin_along(const Vec3d& d, double by_turn) const noexcept {
    return patch_margin(closing_to_fixed(bound_, d, by_turn, settings_), settings_);
  }

  // How far along the unit vector d from the part's centre patches are wanted [m]. A point r that turns by t moves
  // along d by r . (d x t), so the one that gets farthest is the support along d + d x t.
  double reach_along(const Vec3d& d) const noexcept {
    const Vec3d lever = cross(d, bound_.turn);
    const double now = support_along(d), turned = support_along(d + lever) + dot(from_body_, lever);
    return now + margin_along(d, turned - now);
  }

  bool has_faces() const noexcept { return shape_.kind == ShapeKind::kBox || shape_.kind == ShapeKind::kHull; }

  Vec3d to_part(const Vec3d& v) const noexcept { return {dot(axes_.x, v), dot(axes_.y, v), dot(axes_.z, v)}; }

  // The largest d . r over the part, from its centre; of a ball or capsule the radius counts once, as turning does not
  // change it.
  double support_along(const Vec3d& d) const noexcept {
    const Vec3d in_part = to_part(d);
    switch (shape_.kind) {
      case ShapeKind::kSphere:
        return shape_.radius;
      case ShapeKind::kCapsule:
        return shape_.radius + shape_.half_length * std::abs(in_part.z);
      case ShapeKind::kHull:
        return view_of(*hull_).support_along(in_part);
      case ShapeKind::kBox:
      case ShapeKind::kCylinder:
      case ShapeKind::kCone:
      case ShapeKind::kPlane:
      case ShapeKind::kMesh:
      case ShapeKind::kCompound:
        break;
    }
    return dot(shape_.half_extents, abs(in_part));
  }

  // False if the triangle is on the outer side of a face of the box that holds the body, beyond what the body may close
  // towards that side.
  bool overlaps_across_faces(const MeshTriangle& t) const noexcept {
    const Vec3d a = to_part(mesh_.place(t, 0) - centre_), b = to_part(mesh_.place(t, 1) - centre_),
                c = to_part(mesh_.place(t, 2) - centre_);
    for (int i = 0; i < 3; ++i) {
      if (smaller(a[i], smaller(b[i], c[i])) > highest_[i] || larger(a[i], larger(b[i], c[i])) < lowest_[i])
        return false;
    }
    return true;
  }

  const Mesh& mesh_;
  const Shape& shape_;
  const StepSettings& settings_;
  Axes axes_;                 // of the part
  Vec3d centre_, from_body_;  // m: of the part, and from the body's centre
  MotionBound bound_;         // of the body; its advance and turn in the mesh's frame
  const Hull* hull_;
  Vec3d lowest_, highest_;  // m, along the part's axes: where it can touch a triangle in this step
};

}  // namespace tactus::physics
