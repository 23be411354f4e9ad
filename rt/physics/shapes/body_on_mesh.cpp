#include "rt/physics/shapes/body_on_mesh.h"

#include <limits>

#include "rt/physics/shapes/hull_view.h"
#include "rt/physics/shapes/mesh_region.h"
#include "rt/physics/shapes/round_hull.h"

namespace tactus::physics {
namespace {

constexpr double kFlat = 2e-5;  // m: corners of a patch are at most 1e-5 from its plane

// Half the sides of the box about the body's origin that holds it, in the body's frame.
Vec3d half_box(const Shape& shape) noexcept {
  if (shape.kind == ShapeKind::kSphere || shape.kind == ShapeKind::kCapsule)
    return {shape.radius, shape.radius, shape.radius + shape.half_length};
  return shape.half_extents;
}

}  // namespace

BodyOnMesh::BodyOnMesh(const Mesh& mesh, PosedShape body, double reach, Hulls hulls) noexcept
    : mesh_(mesh),
      shape_(body.shape),
      pose_(body.pose),
      axes_(axes_of(body.pose.rotation)),
      reach_(reach),
      half_(half_box(body.shape) + Vec3d{reach, reach, reach}),
      hulls_(hulls) {}

bool BodyOnMesh::is_at_corner(std::uint32_t patch, const Aabb& box) noexcept {
  if (patch != patch_) place_corners(patch);
  if (any_part_) return true;
  for (std::uint32_t c = 0; c < count_; ++c) {
    bool within = true;
    for (int i = 0; i < 3; ++i) {
      const double at = corners_[c].at[i], slack = corners_[c].slack;
      within = within && at >= box.lower[i] - slack && at <= box.upper[i] + slack;
    }
    if (within) return true;
  }
  return false;
}

bool BodyOnMesh::overlaps_box_of_body(const MeshTriangle& t) const noexcept {
  const Vec3d a = mesh_.place(t, 0) - pose_.position, b = mesh_.place(t, 1) - pose_.position,
              c = mesh_.place(t, 2) - pose_.position;
  for (int i = 0; i < 3; ++i) {
    const Vec3d& axis = i == 0 ? axes_.x : i == 1 ? axes_.y : axes_.z;
    const double at_a = dot(axis, a), at_b = dot(axis, b), at_c = dot(axis, c), half = half_[i];
    if (smaller(at_a, smaller(at_b, at_c)) > half || larger(at_a, larger(at_b, at_c)) < -half) return false;
  }
  return true;
}

void BodyOnMesh::place_corners(std::uint32_t patch) noexcept {
  patch_ = patch;
  count_ = 0;
  any_part_ = false;
  const MeshPatch& plane = mesh_.patches[patch];
  constexpr double kAnyHeight = std::numeric_limits<double>::infinity();  // both ends of a capsule's axis count
  const auto place_all = [&](const HullView& hull) noexcept {
    for (std::uint32_t v = 0; v < hull.topology->vertices; ++v) place_corner(plane, hull.vertex(v), reach_ + kFlat);
  };
  switch (shape_.kind) {
    case ShapeKind::kSphere:
      return place_corner(plane, {}, kAnyHeight);
    case ShapeKind::kCapsule:
      // A capsule whose centre is behind the patch touches it where its axis comes through.
      any_part_ = !(dot(plane.normal, pose_.position) > plane.offset);
      place_corner(plane, {0.0, 0.0, -shape_.half_length}, kAnyHeight);
      return place_corner(plane, {0.0, 0.0, shape_.half_length}, kAnyHeight);
    case ShapeKind::kBox:
      return place_all(BoxHull(shape_.half_extents).view());
    case ShapeKind::kHull:
      if (shape_.index < hulls_.size()) place_all(view_of(hulls_[shape_.index]));
      return;
    case ShapeKind::kCylinder:
    case ShapeKind::kCone:  // the polygon that narrow phase uses (collide_cylinder.h)
      return place_all(RoundHull(shape_, Alignment::to(rotate_inverse(pose_.rotation, -plane.normal))).view());
    case ShapeKind::kPlane:
    case ShapeKind::kMesh:
    case ShapeKind::kCompound:
      return;
  }
}

void BodyOnMesh::place_corner(const MeshPatch& plane, const Vec3d& in_body, double highest) noexcept {
  const Vec3d p = pose_ * in_body;
  const double height = dot(plane.normal, p) - plane.offset;
  if (!(height <= highest) || count_ == corners_.size()) return;
  const Vec3d at = p - plane.normal * height;
  corners_[count_++] = {{at.x, at.y, at.z}, kFlat + kFaceSine * std::abs(height)};
}

}  // namespace tactus::physics
