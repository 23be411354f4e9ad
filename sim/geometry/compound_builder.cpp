#include "sim/geometry/compound_builder.h"

#include <algorithm>

#include "rt/base/rotation_axes.h"
#include "rt/physics/shapes/hull_view.h"
#include "rt/physics/shapes/principal_axes.h"

namespace tactus::sim {
namespace {

double volume_of(const physics::Shape& shape, physics::Hulls hulls) {
  return shape.kind == physics::ShapeKind::kHull ? hulls[shape.index].volume : physics::volume_of(shape);
}

// R diag(moments) R^T.
SymMat3d turned(const Quatd& rotation, const Vec3d& moments) {
  SymMat3d sum{};
  for (int k = 0; k < 3; ++k) {
    Vec3d unit;
    unit[k] = 1;
    const Vec3d n = rotate(rotation, unit);
    const double m = moments[k];
    sum.xx += m * n.x * n.x;
    sum.yy += m * n.y * n.y;
    sum.zz += m * n.z * n.z;
    sum.xy += m * n.x * n.y;
    sum.xz += m * n.x * n.z;
    sum.yz += m * n.y * n.z;
  }
  return sum;
}

// Adds a part's inertia about a point at -d from its centre (parallel axes).
void add_inertia(const GivenPart& part, const Vec3d& d, SymMat3d& sum) {
  const SymMat3d own = turned(part.given_from_part.rotation, part.inertia_kg_m2);
  const double m = part.mass_kg, square = norm_squared(d);
  sum.xx += own.xx + m * (square - d.x * d.x);
  sum.yy += own.yy + m * (square - d.y * d.y);
  sum.zz += own.zz + m * (square - d.z * d.z);
  sum.xy += own.xy - m * d.x * d.y;
  sum.xz += own.xz - m * d.x * d.z;
  sum.yz += own.yz - m * d.y * d.z;
}

void add_bounds(const physics::CompoundPart& part, physics::Hulls hulls, physics::Compound& compound) {
  const physics::Aabb box = physics::bounds_of(part.shape, part.body_from_part, 0, hulls);
  for (int k = 0; k < 3; ++k)
    compound.half_extents[k] = std::max({compound.half_extents[k], -box.lower[k], box.upper[k]});
  compound.bounding_radius =
      std::max(compound.bounding_radius, norm(part.body_from_part.position) + physics::bounding_radius(part.shape));
}

}  // namespace

BuiltCompound build_compound(const std::vector<GivenPart>& parts, physics::Hulls hulls,
                             const std::optional<GivenMass>& given) {
  BuiltCompound built;
  Vec3d weighted;
  for (const GivenPart& part : parts) {
    built.mass_kg += part.mass_kg;
    weighted += part.mass_kg * part.given_from_part.position;
  }
  const Vec3d centre = given ? given->centre_m : weighted * (1 / built.mass_kg);
  SymMat3d inertia{};
  if (given)
    inertia = given->inertia_kg_m2;
  else
    for (const GivenPart& part : parts) add_inertia(part, part.given_from_part.position - centre, inertia);
  const physics::Principal principal = physics::principal_axes(inertia);
  built.given_from_body = {centre, quat_from_axes(principal.axis[0], principal.axis[1], principal.axis[2])};
  built.inertia_kg_m2 = {principal.moment[0], principal.moment[1], principal.moment[2]};

  auto own = std::make_shared<std::vector<physics::CompoundPart>>();
  physics::Compound& compound = built.compound;
  compound.half_thickness = physics::half_thickness(parts[0].shape);
  for (const GivenPart& part : parts) {
    own->push_back({part.shape, inverse(built.given_from_body) * part.given_from_part});
    add_bounds(own->back(), hulls, compound);
    compound.half_thickness = std::min(compound.half_thickness, physics::half_thickness(part.shape));
    compound.volume += volume_of(part.shape, hulls);
  }
  compound.inertia_per_kg = built.inertia_kg_m2 * (1 / built.mass_kg);
  compound.parts = *own;
  built.parts = std::move(own);
  return built;
}

}  // namespace tactus::sim
