// The lists to which the shapes of a world's bodies refer by index: hulls, meshes, compounds. Thread: [any], read only.
// The lists must stay at their addresses, unchanged, as long as the worlds exist.
#pragma once

#include "rt/physics/shapes/compound.h"
#include "rt/physics/shapes/hull.h"
#include "rt/physics/shapes/mesh.h"

namespace tactus::physics {

struct ShapeLists {
  Hulls hulls{};
  Meshes meshes{};
  Compounds compounds{};
};

// True if the lists have what the shape refers to: for a body that moves, or one that is fixed.
inline bool is_known(const Shape& shape, bool fixed, const ShapeLists& lists) noexcept {
  switch (shape.kind) {
    case ShapeKind::kSphere:
    case ShapeKind::kCapsule:
    case ShapeKind::kBox:
    case ShapeKind::kCylinder:
    case ShapeKind::kCone:
      return true;
    case ShapeKind::kPlane:
      return fixed;
    case ShapeKind::kHull:
      return shape.index < lists.hulls.size();
    case ShapeKind::kMesh:
      return fixed && shape.index < lists.meshes.size();
    case ShapeKind::kCompound:
      return shape.index < lists.compounds.size();
  }
  return false;
}

}  // namespace tactus::physics
