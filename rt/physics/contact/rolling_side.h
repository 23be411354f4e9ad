// Which contacts roll: those on a ball, where a turn about its centre moves no point of the contact along the normal,
// and those on a surface of revolution, where a turn about the axis moves none.
// Frame: world. Units: m. Thread: [any]; pure.
#pragma once

#include "rt/physics/body.h"
#include "rt/physics/shapes/compound.h"

namespace tactus::physics {

// True if a cylinder or a cone is touched on its side or rim; false on its flat end, where the normal is within 45
// degrees of the axis and the body tilts as a box does. A part of a compound counts if the distance of its axis from
// the body's centre is below its radius: in a rotation by t the gap is wrong by (distance) (1 - cos t) if it rolls, and
// by (radius) (1 - cos t) if its points are fixed to the body.
inline bool touches_on_side(const Body& body, std::uint32_t part, Compounds compounds, const Vec3d& normal) noexcept {
  const ShapeKind kind = part_shape(body.shape, part, compounds).kind;
  if (kind != ShapeKind::kCylinder && kind != ShapeKind::kCone) return false;
  const PosedPart posed = part_of({.shape = body.shape, .pose = body.motion.pose}, part, compounds);
  const Vec3d axis = rotate(posed.pose.rotation, Vec3d{0.0, 0.0, 1.0});
  const double along = dot(axis, normal);
  const Vec3d beside = posed.from_body - dot(posed.from_body, axis) * axis;
  return along * along < 0.5 && norm_squared(beside) < posed.shape.radius * posed.shape.radius;
}

// Distance of a contact point, which is midway between the surfaces, from the centre of the ball that it touches [m].
// 0: the shape is no ball.
constexpr double round_at(const Shape& shape, double separation) noexcept {
  return shape.kind == ShapeKind::kSphere ? shape.radius + 0.5 * separation : 0.0;
}

}  // namespace tactus::physics
