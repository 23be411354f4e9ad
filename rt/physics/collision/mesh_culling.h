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
  // `body`: its shape and its pose in the mesh's frame. `bound`: of its motion, in the world.
  MeshCulling(const Mesh& mesh, PosedShape body, const MotionBound& bound, const Quatd& world_from_mesh,
              const StepSettings& settings, Hulls hulls) noexcept
      : mesh_(mesh),
        shape_(body.shape),
        settings_(settings),
        axes_(axes_of(body.pose.rotation)),
        centre_(body.pose.position),
        bound_(bound),
        hull_(body.shape.kind == ShapeKind::kHull ? &hulls[body.shape.index] : nullptr) {
    bound_.advance = rotate_inverse(world_from_mesh, bound.advance);
    for (int i = 0; i < 3 && has_faces(); ++i) {
      const Vec3d& axis = i == 0 ? axes_.x : i == 1 ? axes_.y : axes_.z;
      lowest_[i] = -body.shape.half_extents[i] - patch_margin(closing_along(-axis, bound_, {}, settings), settings);
      highest_[i] = body.shape.half_extents[i] + patch_margin(closing_along(axis, bound_, {}, settings), settings);
    }
  }

  bool can_touch(std::uint32_t triangle) const noexcept {
    const MeshTriangle& t = mesh_.triangles[triangle];
    const MeshPatch& patch = mesh_.patches[t.patch];
    const double height = dot(patch.normal, centre_) - patch.offset;
    const double closing = closing_along(-patch.normal, bound_, {}, settings_);
    // A body whose centre is behind the patch is not in contact with it; of a capsule, only a part need be in front.
    if (!(height > 0.0) && shape_.kind != ShapeKind::kCapsule) return false;
    // The patch's corners are at most kFlat from its plane.
    if (height - support_along(-patch.normal) > patch_margin(closing, settings_) + kFlat) return false;
    return !has_faces() || overlaps_across_faces(t);
  }

 private:
  static constexpr double kFlat = 1e-5;

  bool has_faces() const noexcept { return shape_.kind == ShapeKind::kBox || shape_.kind == ShapeKind::kHull; }

  Vec3d to_body(const Vec3d& v) const noexcept { return {dot(axes_.x, v), dot(axes_.y, v), dot(axes_.z, v)}; }

  double support_along(const Vec3d& d) const noexcept {
    const Vec3d in_body = to_body(d);
    switch (shape_.kind) {
      case ShapeKind::kSphere:
        return shape_.radius;
      case ShapeKind::kCapsule:
        return shape_.radius + shape_.half_length * std::abs(in_body.z);
      case ShapeKind::kHull:
        return view_of(*hull_).support_along(in_body);
      case ShapeKind::kBox:
      case ShapeKind::kCylinder:
      case ShapeKind::kCone:
      case ShapeKind::kPlane:
      case ShapeKind::kMesh:
      case ShapeKind::kCompound:
        break;
    }
    return dot(shape_.half_extents, abs(in_body));
  }

  // False if the triangle is on the outer side of a face of the box that holds the body, beyond what the body may close
  // towards that side.
  bool overlaps_across_faces(const MeshTriangle& t) const noexcept {
    const Vec3d a = to_body(mesh_.place(t, 0) - centre_), b = to_body(mesh_.place(t, 1) - centre_),
                c = to_body(mesh_.place(t, 2) - centre_);
    for (int i = 0; i < 3; ++i) {
      if (smaller(a[i], smaller(b[i], c[i])) > highest_[i] || larger(a[i], larger(b[i], c[i])) < lowest_[i])
        return false;
    }
    return true;
  }

  const Mesh& mesh_;
  const Shape& shape_;
  const StepSettings& settings_;
  Axes axes_;  // of the body
  Vec3d centre_;
  MotionBound bound_;  // of the body; its advance in the mesh's frame
  const Hull* hull_;
  Vec3d lowest_, highest_;  // m, along the body's axes: where it can touch a triangle in this step
};

}  // namespace tactus::physics
