// The shapes that bodies have: sphere, capsule, box, cylinder, cone, convex hull, compound of these; static plane and
// triangle mesh.
//
// Frame: the body's own, origin at the centre of mass, axes along the principal axes. Units: m, kg, kg m^2. Thread:
// [any]. A plain value: no pointer, no allocation. A hull, mesh or compound is referred to by its index in the
// world's list (shape_lists.h); what the functions below need of it is copied into the shape.
#pragma once

#include <cstdint>

#include "rt/base/spatial.h"
#include "rt/physics/shapes/hull.h"
#include "rt/physics/shapes/shape_kind.h"

namespace tactus::physics {

struct Shape {
  ShapeKind kind{ShapeKind::kSphere};
  std::uint32_t index{0};  // hull, mesh, compound: index in the world's list
  double radius{};         // m: sphere, capsule, cylinder, cone (of its base); hull, compound: of the sphere about the
                           // origin that encloses it
  double half_length{};    // m: capsule, half the distance between the cap centres, along body z; cylinder, cone: half
                           // the height, along body z; compound: half the thickness of its thinnest part
  Vec3d half_extents{};    // m: box; cylinder, cone, hull, mesh, compound: the box about the origin that encloses it

  static constexpr Shape sphere(double radius) noexcept {
    return {.kind = ShapeKind::kSphere, .index = 0, .radius = radius, .half_length = 0.0, .half_extents = {}};
  }
  static constexpr Shape capsule(double radius, double half_length) noexcept {
    return {.kind = ShapeKind::kCapsule, .index = 0, .radius = radius, .half_length = half_length, .half_extents = {}};
  }
  static constexpr Shape cylinder(double radius, double half_height) noexcept {
    return {.kind = ShapeKind::kCylinder,
            .index = 0,
            .radius = radius,
            .half_length = half_height,
            .half_extents = {radius, radius, half_height}};
  }
  // The base is at z = -height / 4, the apex at 3 / 4 of the height.
  static constexpr Shape cone(double radius, double half_height) noexcept {
    return {.kind = ShapeKind::kCone,
            .index = 0,
            .radius = radius,
            .half_length = half_height,
            .half_extents = {radius, radius, 1.5 * half_height}};
  }
  static constexpr Shape box(const Vec3d& half_extents) noexcept {
    return {.kind = ShapeKind::kBox, .index = 0, .radius = 0.0, .half_length = 0.0, .half_extents = half_extents};
  }
  // The half space z <= 0 of the body frame is solid. Fixed bodies only.
  static constexpr Shape plane() noexcept {
    return {.kind = ShapeKind::kPlane, .index = 0, .radius = 0.0, .half_length = 0.0, .half_extents = {}};
  }
  // `index`: position in the world's list.
  static constexpr Shape convex(const Hull& hull, std::uint32_t index) noexcept {
    return {.kind = ShapeKind::kHull,
            .index = index,
            .radius = hull.bounding_radius,
            .half_length = 0.0,
            .half_extents = hull.half_extents};
  }
  // Fixed bodies only; `index` as for hulls.
  static constexpr Shape mesh(const Vec3d& half_extents, std::uint32_t index) noexcept {
    return {.kind = ShapeKind::kMesh, .index = index, .radius = 0.0, .half_length = 0.0, .half_extents = half_extents};
  }

  friend constexpr bool operator==(const Shape&, const Shape&) noexcept = default;
};

// Diagonal of the inertia tensor of a homogeneous body of `mass` [kg m^2]; zero for a plane or mesh, and for a hull or
// compound: use its inertia_per_kg.
Vec3d inertia_of(const Shape& shape, double mass) noexcept;

// Volume [m^3]; zero for a plane or mesh, and for a hull or compound: use its volume.
double volume_of(const Shape& shape) noexcept;

// Radius of the smallest sphere about the body's origin that encloses the shape [m]; +infinity for a plane.
double bounding_radius(const Shape& shape) noexcept;

// Half of the thinnest side; the radius of a sphere or a capsule; of a compound, of its thinnest part [m].
double half_thickness(const Shape& shape) noexcept;

// A shape and where it is: its pose in the frame of a query, the world or a mesh. Refers to both.
struct PosedShape {
  const Shape& shape;
  const Posed& pose;
};

// Axis-aligned box in the world.
struct Aabb {
  Vec3d lower, upper;  // m

  constexpr bool overlaps(const Aabb& o) const noexcept {
    return lower.x <= o.upper.x && o.lower.x <= upper.x && lower.y <= o.upper.y && o.lower.y <= upper.y &&
           lower.z <= o.upper.z && o.lower.z <= upper.z;
  }
  constexpr bool holds(const Aabb& o) const noexcept {
    return lower.x <= o.lower.x && o.upper.x <= upper.x && lower.y <= o.lower.y && o.upper.y <= upper.y &&
           lower.z <= o.lower.z && o.upper.z <= upper.z;
  }
  // Grown by `by` [m] on every side.
  constexpr Aabb grown(double by) const noexcept {
    const Vec3d all{by, by, by};
    return {lower - all, upper + all};
  }
};

// The shape's box at `world_from_body`, grown by `margin` on every side. Unbounded for a plane. For a hull, mesh or
// compound, the box of its half_extents, so larger than necessary.
Aabb bounds_of(const Shape& shape, const Posed& world_from_body, double margin) noexcept;

}  // namespace tactus::physics
