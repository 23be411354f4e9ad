// Which contacts roll: those on a ball, where a turn about its centre moves no point of the contact along the normal,
// and those on a surface of revolution, where a turn about the axis moves none.
// Frame: world. Units: m. Thread: [any]; pure.
#pragma once

#include "rt/physics/body.h"
#include "rt/physics/shapes/compound.h"

namespace tactus::physics {

// True for the side and the rim of a cylinder or a cone; not for its flat end, on which it tilts as a box does: there
// the normal is within 45 degrees of the axis. A part of a compound counts if the body's centre is nearer to the part's
// axis than its surface is: in a turn by t one rule is wrong by (distance) (1 - cos t), the other by
// (radius) (1 - cos t).
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
