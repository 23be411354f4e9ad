#include "rt/physics/shapes/shape.h"

#include <limits>

namespace tactus::physics {
namespace {

// A cylinder and two half balls, weighted by their share of the volume (divided by pi r^2, so that r = 0 gives a rod).
Vec3d inertia_of_capsule(double radius, double half_length, double mass) noexcept {
  const double cylinder = 2.0 * half_length, ball = 4.0 / 3.0 * radius;
  if (!(cylinder + ball > 0.0)) return {};
  const double mass_cylinder = mass * (cylinder / (cylinder + ball)), mass_ball = mass - mass_cylinder;
  const double r2 = radius * radius, l2 = half_length * half_length;
  const double along = mass_cylinder * r2 / 2.0 + mass_ball * r2 * 0.4;
  // The centre of mass of a half ball is 3/8 r beyond its flat side.
  const double across =
      mass_cylinder * (r2 / 4.0 + l2 / 3.0) + mass_ball * (r2 * 0.4 + l2 + 0.75 * half_length * radius);
  return {across, across, along};
}

// Half extents of a disk about the origin along the axes of the world; `axis`: its normal, unit.
Vec3d disk_extents(double radius, const Vec3d& axis) noexcept {
  Vec3d extents;
  for (int i = 0; i < 3; ++i) extents[i] = radius * std::sqrt(larger(1.0 - axis[i] * axis[i], 0.0));
  return extents;
}

}  // namespace

Vec3d inertia_of(const Shape& shape, double mass) noexcept {
  switch (shape.kind) {
    case ShapeKind::kSphere: {
      const double i = 0.4 * mass * shape.radius * shape.radius;
      return {i, i, i};
    }
    case ShapeKind::kCapsule:
      return inertia_of_capsule(shape.radius, shape.half_length, mass);
    case ShapeKind::kBox: {
      const Vec3d h2 = scale(shape.half_extents, shape.half_extents);
      return Vec3d{h2.y + h2.z, h2.x + h2.z, h2.x + h2.y} * (mass / 3.0);
    }
    case ShapeKind::kCylinder: {
      const double r2 = shape.radius * shape.radius, l2 = shape.half_length * shape.half_length;
      const double across = mass * (r2 / 4.0 + l2 / 3.0);
      return {across, across, mass * r2 / 2.0};
    }
    case ShapeKind::kCone: {  // about the centre of mass
      const double r2 = shape.radius * shape.radius, l2 = shape.half_length * shape.half_length;
      const double across = mass * 0.15 * (r2 + l2);
      return {across, across, mass * 0.3 * r2};
    }
    case ShapeKind::kPlane:
    case ShapeKind::kHull:
    case ShapeKind::kMesh:
    case ShapeKind::kCompound:
      break;
  }
  return {};
}

double volume_of(const Shape& shape) noexcept {
  constexpr double pi = 3.14159265358979323846;
  const double r2 = shape.radius * shape.radius;
  switch (shape.kind) {
    case ShapeKind::kSphere:
      return 4.0 / 3.0 * pi * r2 * shape.radius;
    case ShapeKind::kCapsule:
      return pi * r2 * (2.0 * shape.half_length + 4.0 / 3.0 * shape.radius);
    case ShapeKind::kCylinder:
      return 2.0 * pi * r2 * shape.half_length;
    case ShapeKind::kCone:
      return 2.0 / 3.0 * pi * r2 * shape.half_length;
    case ShapeKind::kBox:
      return 8.0 * shape.half_extents.x * shape.half_extents.y * shape.half_extents.z;
    case ShapeKind::kPlane:
    case ShapeKind::kHull:
    case ShapeKind::kMesh:
    case ShapeKind::kCompound:
      break;
  }
  return 0.0;
}

double bounding_radius(const Shape& shape) noexcept {
  switch (shape.kind) {
    case ShapeKind::kSphere:
    case ShapeKind::kHull:
    case ShapeKind::kCompound:
      return shape.radius;
    case ShapeKind::kCapsule:
      return shape.radius + shape.half_length;
    case ShapeKind::kCylinder:
      return std::sqrt(shape.radius * shape.radius + shape.half_length * shape.half_length);
    case ShapeKind::kCone: {
      const double low = 0.5 * shape.half_length;
      return larger(1.5 * shape.half_length, std::sqrt(shape.radius * shape.radius + low * low));
    }
    case ShapeKind::kBox:
    case ShapeKind::kMesh:
      return norm(shape.half_extents);
    case ShapeKind::kPlane:
      break;
  }
  return std::numeric_limits<double>::infinity();
}

double half_thickness(const Shape& shape) noexcept {
  const Vec3d& half = shape.half_extents;
  const bool round = shape.kind == ShapeKind::kSphere || shape.kind == ShapeKind::kCapsule;
  if (shape.kind == ShapeKind::kCompound) return shape.half_length;
  return round ? shape.radius : smaller(half.x, smaller(half.y, half.z));
}

Aabb bounds_of(const Shape& shape, const Posed& world_from_body, double margin) noexcept {
  const Quatd& q = world_from_body.rotation;
  Vec3d extents;
  switch (shape.kind) {
    case ShapeKind::kSphere:
      extents = {shape.radius, shape.radius, shape.radius};
      break;
    case ShapeKind::kCapsule:
      extents = abs(rotate(q, Vec3d{0.0, 0.0, shape.half_length})) + Vec3d{shape.radius, shape.radius, shape.radius};
      break;
    case ShapeKind::kCylinder: {
      const Vec3d axis = rotate(q, Vec3d{0.0, 0.0, 1.0});
      extents = abs(axis) * shape.half_length + disk_extents(shape.radius, axis);
      break;
    }
    case ShapeKind::kCone: {
      const Vec3d axis = rotate(q, Vec3d{0.0, 0.0, 1.0}), base = axis * (-0.5 * shape.half_length),
                  apex = axis * (1.5 * shape.half_length), rim = disk_extents(shape.radius, axis);
      Aabb box;
      for (int i = 0; i < 3; ++i) {
        box.lower[i] = world_from_body.position[i] + smaller(base[i] - rim[i], apex[i]) - margin;
        box.upper[i] = world_from_body.position[i] + larger(base[i] + rim[i], apex[i]) + margin;
      }
      return box;
    }
    case ShapeKind::kBox:
    case ShapeKind::kHull:
    case ShapeKind::kMesh:
    case ShapeKind::kCompound: {
      const Vec3d& h = shape.half_extents;
      extents = abs(rotate(q, Vec3d{h.x, 0.0, 0.0})) + abs(rotate(q, Vec3d{0.0, h.y, 0.0})) +
                abs(rotate(q, Vec3d{0.0, 0.0, h.z}));
      break;
    }
    case ShapeKind::kPlane: {
      constexpr double infinity = std::numeric_limits<double>::infinity();
      return {{-infinity, -infinity, -infinity}, {infinity, infinity, infinity}};
    }
  }
  extents += Vec3d{margin, margin, margin};
  return {world_from_body.position - extents, world_from_body.position + extents};
}

}  // namespace tactus::physics
