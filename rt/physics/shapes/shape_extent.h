// How far a convex shape reaches along a direction, and its flat faces. Frame: the shape's own. Units: m. Thread:
// [any]; pure. Bound: linear in the vertices and faces of a hull.
#pragma once

#include <algorithm>
#include <cmath>

#include "rt/physics/shapes/hull_view.h"
#include "rt/physics/shapes/shape.h"

namespace tactus::physics {

// The largest x . d over the shape (its support function); `d` of unit length. 0 for planes, meshes and compounds.
inline double extent_along(const Shape& shape, Hulls hulls, const Vec3d& d) noexcept {
  const double beside = std::sqrt(d.x * d.x + d.y * d.y);
  switch (shape.kind) {
    case ShapeKind::kSphere:
      return shape.radius;
    case ShapeKind::kCapsule:
      return shape.radius + shape.half_length * std::abs(d.z);
    case ShapeKind::kBox: {
      const Vec3d& h = shape.half_extents;
      return h.x * std::abs(d.x) + h.y * std::abs(d.y) + h.z * std::abs(d.z);
    }
    case ShapeKind::kCylinder:
      return shape.half_length * std::abs(d.z) + shape.radius * beside;
    case ShapeKind::kCone:
      return std::max(1.5 * shape.half_length * d.z, shape.radius * beside - 0.5 * shape.half_length * d.z);
    case ShapeKind::kHull:
      return shape.index < hulls.size() ? view_of(hulls[shape.index]).support_along(d) : 0.0;
    case ShapeKind::kPlane:
    case ShapeKind::kMesh:
    case ShapeKind::kCompound:
      return 0.0;
  }
  return 0.0;
}

// A flat face: the points x of the shape have normal . x <= offset.
struct FlatFace {
  Vec3d normal;     // unit, outwards
  double offset{};  // m
};

// Of which faces: `p`, a point of the shape, is within `reach` [m] of their plane, and |normal . n| < most.
struct FacesWanted {
  Vec3d p;
  double reach{};
  Vec3d n;
  double most{};

  bool holds(const FlatFace& face) const noexcept {
    return std::abs(dot(face.normal, p) - face.offset) <= reach && std::abs(dot(face.normal, n)) < most;
  }
};

// Calls `f(FlatFace)` for each such face: sides of boxes and hulls, ends of cylinders, bases of cones.
template <class F>
TACTUS_INLINE void for_each_face(const Shape& shape, Hulls hulls, const FacesWanted& wanted, F&& f) noexcept {
  const auto try_end = [&](double side, double offset) noexcept {
    const FlatFace face{{0.0, 0.0, side}, offset};
    if (wanted.holds(face)) f(face);
  };
  switch (shape.kind) {
    case ShapeKind::kBox:
      for (int k = 0; k < 3; ++k) {
        if (!(std::abs(std::abs(wanted.p[k]) - shape.half_extents[k]) <= wanted.reach)) continue;
        if (!(std::abs(wanted.n[k]) < wanted.most)) continue;
        FlatFace face{{}, shape.half_extents[k]};
        face.normal[k] = wanted.p[k] > 0.0 ? 1.0 : -1.0;
        f(face);
      }
      return;
    case ShapeKind::kCylinder:
      try_end(1.0, shape.half_length);
      try_end(-1.0, shape.half_length);
      return;
    case ShapeKind::kCone:
      return try_end(-1.0, 0.5 * shape.half_length);
    case ShapeKind::kHull: {
      if (shape.index >= hulls.size()) return;
      const HullView hull = view_of(hulls[shape.index]);
      using V = HullView::V;
      const Vec3<V> p = HullView::spread(wanted.p), n = HullView::spread(wanted.n);
      for (std::uint32_t first = 0; first < hull.topology->faces; first += kLanes<V>) {
        V offset;
        load(offset, hull.offsets + first);
        const V height = hull.over_faces(p, first) - offset, along = hull.over_faces(n, first);
        if (!any(both(abs(height) <= V(wanted.reach), abs(along) < V(wanted.most)))) continue;
        const std::uint32_t end = std::min(first + static_cast<std::uint32_t>(kLanes<V>), hull.topology->faces);
        for (std::uint32_t i = first; i < end; ++i) {
          const FlatFace face{hull.normal(i), hull.offsets[i]};
          if (wanted.holds(face)) f(face);
        }
      }
      return;
    }
    case ShapeKind::kSphere:
    case ShapeKind::kCapsule:
    case ShapeKind::kPlane:
    case ShapeKind::kMesh:
    case ShapeKind::kCompound:
      return;
  }
}

}  // namespace tactus::physics
