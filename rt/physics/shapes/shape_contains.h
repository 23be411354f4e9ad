// Is a point inside a convex shape? Frame: the shape's own. Units: m. Thread: [any]; pure. Bound: linear in the faces
// of a hull.
#pragma once

#include <cmath>

#include "rt/physics/shapes/hull.h"
#include "rt/physics/shapes/shape.h"

namespace tactus::physics {

// `margin`: the shape counts as larger by this, at corners by up to a few times this. False for planes, meshes,
// compounds and unknown hulls.
inline bool contains(const Shape& shape, Hulls hulls, const Vec3d& p, double margin) noexcept {
  const double beside = std::sqrt(p.x * p.x + p.y * p.y);
  switch (shape.kind) {
    case ShapeKind::kSphere:
      return norm(p) <= shape.radius + margin;
    case ShapeKind::kCapsule: {
      const double beyond = std::max(0.0, std::abs(p.z) - shape.half_length);
      return std::sqrt(beside * beside + beyond * beyond) <= shape.radius + margin;
    }
    case ShapeKind::kBox: {
      const Vec3d& h = shape.half_extents;
      return std::abs(p.x) <= h.x + margin && std::abs(p.y) <= h.y + margin && std::abs(p.z) <= h.z + margin;
    }
    case ShapeKind::kCylinder:
      return beside <= shape.radius + margin && std::abs(p.z) <= shape.half_length + margin;
    case ShapeKind::kCone: {
      const double to_apex = 1.5 * shape.half_length - p.z;
      return p.z >= -0.5 * shape.half_length - margin &&
             beside <= 0.5 * shape.radius * to_apex / shape.half_length + margin;
    }
    case ShapeKind::kHull: {
      if (shape.index >= hulls.size()) return false;
      const Hull& hull = hulls[shape.index];
      for (std::uint32_t f = 0; f < hull.topology.faces; ++f)
        if (dot(hull.normal(f), p) > hull.offsets[f] + margin) return false;
      return true;
    }
    case ShapeKind::kPlane:
    case ShapeKind::kMesh:
    case ShapeKind::kCompound:
      return false;
  }
  return false;
}

}  // namespace tactus::physics
