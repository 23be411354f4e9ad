#include "tools/import/body_mass.h"

#include <algorithm>
#include <cmath>

#include "rt/physics/shapes/shape.h"

namespace tactus::scene_import {
namespace {

constexpr double kSame = 1e-10;  // of moments and sizes: rounding

physics::Shape shape_of(const DraftPart& part) {
  switch (part.shape) {
    case DraftShape::kSphere:
      return physics::Shape::sphere(part.size.x);
    case DraftShape::kCapsule:
      return physics::Shape::capsule(part.size.x, part.size.y);
    case DraftShape::kCylinder:
      return physics::Shape::cylinder(part.size.x, part.size.y);
    default:
      return physics::Shape::box(part.size);
  }
}

bool is_inside(const std::vector<Vec3d>& points, const Vec3d& centre) {
  const auto surface = surface_of(points);
  if (!surface.ok()) return false;
  const auto& corners = surface.value().corners;
  return std::ranges::all_of(surface.value().triangles, [&](const auto& t) {
    const Vec3d &a = corners[t[0]], &b = corners[t[1]], &c = corners[t[2]];
    return dot(cross(b - a, c - a), centre - a) < 0;
  });
}

bool is_diagonal(const SymMat3d& m) {
  const double tolerance = kSame * trace(m);
  return std::abs(m.xy) <= tolerance && std::abs(m.xz) <= tolerance && std::abs(m.yz) <= tolerance;
}

// A sphere, a capsule, a cylinder or a box with its centre of mass in the middle and principal axes along its own:
// true, and its moments are there where they are not those of the solid.
bool set_central(const MassProperties& own, DraftBody& body) {
  const physics::Shape shape = shape_of(body.parts[0]);
  if (norm(own.centre) > kSame * physics::bounding_radius(shape) || !is_diagonal(own.inertia)) return false;
  const Vec3d solid = physics::inertia_of(shape, own.mass);
  const SymMat3d moments{own.inertia.xx, own.inertia.yy, own.inertia.zz, 0, 0, 0};
  if (largest_difference(moments, {solid.x, solid.y, solid.z, 0, 0, 0}) > kSame * trace(moments))
    body.inertia = moments;
  return true;
}

}  // namespace

void set_parts(std::vector<DraftPart> parts, const Posed& world_from_body, DraftBody& body) {
  body.parts = std::move(parts);
  body.compound = body.parts.size() > 1;
  if (!body.compound) {
    body.pose = body.parts[0].pose;
    body.parts[0].pose = {};
    return;
  }
  body.pose = world_from_body;
  for (DraftPart& part : body.parts) part.pose = inverse(world_from_body) * part.pose;
}

void set_mass(const MassProperties& whole, DraftBody& body) {
  const MassProperties own = in_frame(whole, body.pose);
  body.mass_kg = own.mass;
  const bool hull = body.parts[0].shape == DraftShape::kHull;
  if (!body.compound && !hull && set_central(own, body)) return;
  if (!hull || !is_inside(body.parts[0].points, own.centre)) body.compound = true;
  body.inertia = own.inertia;
  body.centre = own.centre;
}

}  // namespace tactus::scene_import
