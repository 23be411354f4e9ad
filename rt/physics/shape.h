// The shapes that bodies have: sphere, capsule, box; static plane.
//
// Frame: the body's own, origin at the centre of mass, axes along the principal axes. Units: m, kg, kg m^2.
// Thread: [any]. A plain value: no pointer, no allocation.
#pragma once

#include <cstdint>

#include "rt/base/spatial.h"

namespace tactus::physics {

enum class ShapeKind : std::uint32_t { kSphere = 0, kCapsule = 1, kBox = 2, kPlane = 3 };

template <class T>
struct Shape {
  ShapeKind kind{ShapeKind::kSphere};
  T radius{};              // m: sphere, capsule; 0 otherwise
  T half_length{};         // m: capsule, half the distance between the cap centres, along body z
  Vec3<T> half_extents{};  // m: box

  static constexpr Shape sphere(T radius) noexcept { return {ShapeKind::kSphere, radius, T(0), {}}; }
  static constexpr Shape capsule(T radius, T half_length) noexcept {
    return {ShapeKind::kCapsule, radius, half_length, {}};
  }
  static constexpr Shape box(const Vec3<T>& half_extents) noexcept {
    return {ShapeKind::kBox, T(0), T(0), half_extents};
  }
  // The half space z <= 0 of the body frame is solid. Fixed bodies only.
  static constexpr Shape plane() noexcept { return {ShapeKind::kPlane, T(0), T(0), {}}; }

  friend constexpr bool operator==(const Shape&, const Shape&) noexcept = default;
};

// Diagonal of the inertia tensor of a homogeneous body of `mass` [kg m^2]; zero for a plane.
template <class T>
Vec3<T> inertia_of(const Shape<T>& shape, T mass) noexcept;

// Volume [m^3]; zero for a plane.
template <class T>
T volume_of(const Shape<T>& shape) noexcept;

// Radius of the smallest sphere about the body's origin that holds the shape [m]; +infinity for a plane.
template <class T>
T bounding_radius(const Shape<T>& shape) noexcept;

// Axis-aligned box in the world.
template <class T>
struct Aabb {
  Vec3<T> lower, upper;  // m

  constexpr bool overlaps(const Aabb& o) const noexcept {
    return lower.x <= o.upper.x && o.lower.x <= upper.x && lower.y <= o.upper.y && o.lower.y <= upper.y &&
           lower.z <= o.upper.z && o.lower.z <= upper.z;
  }
};

// The shape's box at `world_from_body`, grown by `margin` on every side. A plane's is unbounded.
template <class T>
Aabb<T> bounds_of(const Shape<T>& shape, const Pose<T>& world_from_body, T margin) noexcept;

}  // namespace tactus::physics
