// A compound: several convex shapes in one rigid body, such as a mug with a handle or a chair. Built at set-up
// (make_compound) and never changed.
//
// Narrow phase treats each part as a shape of its own: a pair of bodies has one contact for each pair of parts that are
// near each other (PairKey has the parts' indices). Everything else (bounds, margins, motion, impulses, friction) is
// the body's. Parts may overlap each other; they never collide with parts of their own body. Frame: the body's own,
// origin at the centre of mass, axes along the principal axes. Units: m, kg, kg m^2. A Shape refers to a compound by
// its index in the list that both worlds get at set-up (shape_lists.h). Thread: make_compound [setup]; the rest [any],
// read only. Bound: kMaxParts parts; two compounds have at most kMaxParts^2 pairs of parts.
#pragma once

#include <span>

#include "rt/base/ids.h"
#include "rt/base/spatial.h"
#include "rt/physics/shapes/shape.h"

namespace tactus::physics {

struct CompoundPart {
  Shape shape;  // any convex shape
  Posed body_from_part;
  friend constexpr bool operator==(const CompoundPart&, const CompoundPart&) noexcept = default;
};

struct Compound {
  std::span<const CompoundPart> parts;
  Vec3d half_extents;        // m: the box about the origin that encloses all parts
  double bounding_radius{};  // m: of the sphere about the origin that encloses all parts
  double half_thickness{};   // m: of the thinnest part
  double volume{};           // m^3: sum of the parts' volumes
  Vec3d inertia_per_kg{};    // m^2: principal moments per kg
};

// The list to which compound shapes refer. Read only; must stay at its address as long as the worlds exist.
using Compounds = std::span<const Compound>;

inline Shape compound_shape(const Compound& compound, std::uint32_t index) noexcept {
  return {.kind = ShapeKind::kCompound,
          .index = index,
          .radius = compound.bounding_radius,
          .half_length = compound.half_thickness,
          .half_extents = compound.half_extents};
}

// Number of convex parts of any shape; 1 if it is no compound.
inline std::uint32_t parts_of(const Shape& shape, Compounds compounds) noexcept {
  return shape.kind == ShapeKind::kCompound ? static_cast<std::uint32_t>(compounds[shape.index].parts.size()) : 1;
}

// One convex part of a body: its shape, where it is, and its centre from the body's centre, both in the frame in which
// the body's pose is given. Refers to the shape.
struct PosedPart {
  const Shape& shape;
  Posed pose;
  Vec3d from_body;  // m

  PosedShape posed() const noexcept { return {.shape = shape, .pose = pose}; }
};

// `part`: below parts_of the shape; ignored if the shape is no compound.
inline PosedPart part_of(PosedShape body, std::uint32_t part, Compounds compounds) noexcept {
  if (body.shape.kind != ShapeKind::kCompound) return {.shape = body.shape, .pose = body.pose, .from_body = {}};
  const CompoundPart& own = compounds[body.shape.index].parts[part];
  const Vec3d from_body = rotate(body.pose.rotation, own.body_from_part.position);
  return {.shape = own.shape,
          .pose = {body.pose.position + from_body, body.pose.rotation * own.body_from_part.rotation},
          .from_body = from_body};
}

// The convex shape of one part; the shape itself if it is no compound.
inline const Shape& part_shape(const Shape& shape, std::uint32_t part, Compounds compounds) noexcept {
  return shape.kind == ShapeKind::kCompound ? compounds[shape.index].parts[part].shape : shape;
}

}  // namespace tactus::physics
