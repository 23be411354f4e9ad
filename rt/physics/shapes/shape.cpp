#include "rt/physics/shapes/shape.h"

#include <limits>

namespace tactus::physics {
namespace {

// A cylinder and two half balls, by their shares of the volume (divided by pi r^2, so that a thin capsule is a rod).
template <class T>
Vec3<T> inertia_of_capsule(T radius, T half_length, T mass) noexcept {
  const T cylinder = T(2) * half_length, ball = T(4) / T(3) * radius;
  if (!(cylinder + ball > T(0))) return {};
  const T mass_cylinder = mass * (cylinder / (cylinder + ball)), mass_ball = mass - mass_cylinder;
  const T r2 = radius * radius, l2 = half_length * half_length;
  const T along = mass_cylinder * r2 / T(2) + mass_ball * r2 * T(0.4);
  // A half ball about the capsule's centre: its own centre of mass is 3/8 r beyond its flat side.
  const T across =
      mass_cylinder * (r2 / T(4) + l2 / T(3)) + mass_ball * (r2 * T(0.4) + l2 + T(0.75) * half_length * radius);
  return {across, across, along};
}

}  // namespace

template <class T>
Vec3<T> inertia_of(const Shape<T>& shape, T mass) noexcept {
  switch (shape.kind) {
    case ShapeKind::kSphere: {
      const T i = T(0.4) * mass * shape.radius * shape.radius;
      return {i, i, i};
    }
    case ShapeKind::kCapsule:
      return inertia_of_capsule(shape.radius, shape.half_length, mass);
    case ShapeKind::kBox: {
      const Vec3<T> h2 = scale(shape.half_extents, shape.half_extents);
      return Vec3<T>{h2.y + h2.z, h2.x + h2.z, h2.x + h2.y} * (mass / T(3));
    }
    case ShapeKind::kPlane:
    case ShapeKind::kHull:
    case ShapeKind::kMesh:
      break;
  }
  return {};
}

template <class T>
T volume_of(const Shape<T>& shape) noexcept {
  constexpr T pi = T(3.14159265358979323846);
  const T r2 = shape.radius * shape.radius;
  switch (shape.kind) {
    case ShapeKind::kSphere:
      return T(4) / T(3) * pi * r2 * shape.radius;
    case ShapeKind::kCapsule:
      return pi * r2 * (T(2) * shape.half_length + T(4) / T(3) * shape.radius);
    case ShapeKind::kBox:
      return T(8) * shape.half_extents.x * shape.half_extents.y * shape.half_extents.z;
    case ShapeKind::kPlane:
    case ShapeKind::kHull:
    case ShapeKind::kMesh:
      break;
  }
  return T(0);
}

template <class T>
T bounding_radius(const Shape<T>& shape) noexcept {
  switch (shape.kind) {
    case ShapeKind::kSphere:
    case ShapeKind::kHull:
      return shape.radius;
    case ShapeKind::kCapsule:
      return shape.radius + shape.half_length;
    case ShapeKind::kBox:
    case ShapeKind::kMesh:
      return norm(shape.half_extents);
    case ShapeKind::kPlane:
      break;
  }
  return std::numeric_limits<T>::infinity();
}

template <class T>
Aabb<T> bounds_of(const Shape<T>& shape, const Pose<T>& world_from_body, T margin) noexcept {
  const Quat<T>& q = world_from_body.rotation;
  Vec3<T> reach;
  switch (shape.kind) {
    case ShapeKind::kSphere:
      reach = {shape.radius, shape.radius, shape.radius};
      break;
    case ShapeKind::kCapsule:
      reach =
          abs(rotate(q, Vec3<T>{T(0), T(0), shape.half_length})) + Vec3<T>{shape.radius, shape.radius, shape.radius};
      break;
    case ShapeKind::kBox:
    case ShapeKind::kHull:
    case ShapeKind::kMesh: {
      const Vec3<T>& h = shape.half_extents;
      reach = abs(rotate(q, Vec3<T>{h.x, T(0), T(0)})) + abs(rotate(q, Vec3<T>{T(0), h.y, T(0)})) +
              abs(rotate(q, Vec3<T>{T(0), T(0), h.z}));
      break;
    }
    case ShapeKind::kPlane: {
      constexpr T infinity = std::numeric_limits<T>::infinity();
      return {{-infinity, -infinity, -infinity}, {infinity, infinity, infinity}};
    }
  }
  reach += Vec3<T>{margin, margin, margin};
  return {world_from_body.position - reach, world_from_body.position + reach};
}

#define TACTUS_INSTANTIATE(T)                                  \
  template Vec3<T> inertia_of<T>(const Shape<T>&, T) noexcept; \
  template T volume_of<T>(const Shape<T>&) noexcept;           \
  template T bounding_radius<T>(const Shape<T>&) noexcept;     \
  template Aabb<T> bounds_of<T>(const Shape<T>&, const Pose<T>&, T) noexcept;
TACTUS_INSTANTIATE(double)
TACTUS_INSTANTIATE(float)
#undef TACTUS_INSTANTIATE

}  // namespace tactus::physics
