// Which contacts roll: those on a ball, where a turn about its centre moves no point of the contact along the normal,
// and those on a surface of revolution, where a turn about the axis moves none.
// Frame: world. Units: m. Thread: [any]; pure.
#pragma once

#include <algorithm>
#include <cmath>

#include "rt/physics/body.h"
#include "rt/physics/collision/manifold.h"
#include "rt/physics/shapes/compound.h"

namespace tactus::physics {

// The largest |n . axis| at which a shape is touched on its side; 0: it has none. A cylinder or a cone: beyond 45
// degrees it is touched on its flat end and tilts as a box does. A capsule: where a rotation by t across the axis
// changes the gap by (half_length) |n . axis| (1 - cos t), which is then neglected, no more than by the (radius) (1 -
// cos t) that would be added if the points were fixed to the body.
inline double steepest_side(const Shape& shape) noexcept {
  if (shape.kind == ShapeKind::kCylinder || shape.kind == ShapeKind::kCone) return std::sqrt(0.5);
  if (shape.kind == ShapeKind::kCapsule) return shape.radius / std::max(shape.half_length, shape.radius);
  return 0.0;
}

// True if a body of revolution is touched on its side or rim; a capsule along a line, in two points: on a single point
// it tilts. A part of a compound counts if the distance of its axis from the body's centre is below its radius: in a
// rotation by t the gap is wrong by (distance) (1 - cos t) if it rolls, and by (radius) (1 - cos t) if its points are
// fixed to the body.
inline bool touches_on_side(const Body& body, std::uint32_t part, Compounds compounds, const Manifold& touch) noexcept {
  const Shape& shape = part_shape(body.shape, part, compounds);
  const double steepest = steepest_side(shape);
  if (steepest == 0.0 || (shape.kind == ShapeKind::kCapsule && touch.count < 2)) return false;
  const PosedPart posed = part_of({.shape = body.shape, .pose = body.motion.pose}, part, compounds);
  const Vec3d axis = rotate(posed.pose.rotation, Vec3d{0.0, 0.0, 1.0});
  const Vec3d beside = posed.from_body - dot(posed.from_body, axis) * axis;
  return std::abs(dot(axis, touch.normal)) < steepest && norm_squared(beside) < shape.radius * shape.radius;
}

// Distance of a contact point, which is midway between the surfaces, from the centre of the ball that it touches [m].
// 0: the shape is no ball.
constexpr double round_at(const Shape& shape, double separation) noexcept {
  return shape.kind == ShapeKind::kSphere ? shape.radius + 0.5 * separation : 0.0;
}

}  // namespace tactus::physics
