#include "tools/import/rigid_group.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "rt/physics/shapes/shape.h"

namespace tactus::scene_import {
namespace {

constexpr double kSame = 1e-10;      // of moments and sizes: rounding
constexpr double kNearby_m = 0.005;  // parts closer than this might touch
constexpr double kNeverReached_m = 1000;

physics::Shape shape_of(const DraftBody& body) {
  switch (body.shape) {
    case DraftShape::kSphere:
      return physics::Shape::sphere(body.size.x);
    case DraftShape::kCapsule:
      return physics::Shape::capsule(body.size.x, body.size.y);
    default:
      return physics::Shape::box(body.size);
  }
}

double radius_of(const DraftBody& body) {
  if (body.shape == DraftShape::kBox) return norm(body.size);
  double radius = body.size.x + body.size.y;
  for (const Vec3d& p : body.points) radius = std::max(radius, norm(p));
  return radius;
}

MassProperties unit_solid(const DraftBody& body) {
  if (body.shape != DraftShape::kHull) {
    const physics::Shape shape = shape_of(body);
    const Vec3d moments = physics::inertia_of(shape, 1);
    return {physics::volume_of(shape), {}, {moments.x, moments.y, moments.z, 0, 0, 0}};
  }
  const auto surface = surface_of(body.points);
  if (!surface.ok()) return {};
  MassProperties solid = solid_of(surface.value());
  if (solid.mass > 0) solid.inertia = scaled(1 / solid.mass, solid.inertia);
  return solid;  // the volume, and moments per kg
}

bool is_inside(const std::vector<Vec3d>& points, const Vec3d& centre) {
  const auto surface = surface_of(points);
  if (!surface.ok()) return false;
  for (const auto& t : surface.value().triangles) {
    const Vec3d &a = surface.value().corners[t[0]], &b = surface.value().corners[t[1]],
                &c = surface.value().corners[t[2]];
    if (dot(cross(b - a, c - a), centre - a) >= 0) return false;
  }
  return true;
}

bool is_diagonal(const SymMat3d& m) {
  const double room = kSame * trace(m);
  return std::abs(m.xy) <= room && std::abs(m.xz) <= room && std::abs(m.yz) <= room;
}

}  // namespace

double volume_of(const DraftBody& body) { return unit_solid(body).mass; }

MassProperties solid_body(const DraftBody& body, double mass) {
  MassProperties solid = unit_solid(body);
  return {mass, solid.centre, scaled(mass, solid.inertia)};
}

std::string set_mass(const MassProperties& own, DraftBody& body, Account& account) {
  if (!is_a_body(own)) return fmt::format("no rigid body has a mass of {:g} kg and these moments", own.mass);
  body.mass_kg = own.mass;
  const bool central = norm(own.centre) <= kSame * radius_of(body);
  if (body.shape != DraftShape::kHull && central && is_diagonal(own.inertia)) {
    if (largest_difference(own.inertia, solid_body(body, own.mass).inertia) > kSame * trace(own.inertia))
      body.inertia = SymMat3d{own.inertia.xx, own.inertia.yy, own.inertia.zz, 0, 0, 0};
    return {};
  }
  if (body.shape != DraftShape::kHull) {
    const bool box = body.shape == DraftShape::kBox;
    HullPoints hull = box                                  ? box_hull(body.size)
                      : body.shape == DraftShape::kCapsule ? capsule_hull(body.size.x, body.size.y)
                                                           : ellipsoid_hull({body.size.x, body.size.x, body.size.x});
    if (!box)
      account.change(fmt::format("\"{}\": its mass is not central, so it is a hull, at most {:.3g} mm from its surface",
                                 body.name, 1e3 * hull.deviation_m));
    body.shape = DraftShape::kHull;
    body.points = std::move(hull.points);
  }
  if (!is_inside(body.points, own.centre)) return "its centre of mass is outside of its shape";
  body.inertia = own.inertia;
  body.centre = own.centre;
  return {};
}

std::string RigidGroup::settle(Account& account) {
  if (kinematic) return {};
  if (!is_a_body(whole)) return fmt::format("has a mass of {:g} kg, or moments of none that moves", whole.mass);
  if (parts.size() == 1) return set_mass(in_frame(whole, parts[0].body.pose), parts[0].body, account);
  return settle_several(account);
}

std::string RigidGroup::settle_several(Account& account) {
  double sum = 0;
  for (RigidPart& part : parts) {
    if (part.weight < 0) part.weight *= -volume_of(part.body);
    sum += part.weight;
  }
  if (!(sum > 0)) return "its shapes have no mass";
  for (RigidPart& part : parts) part.weight *= whole.mass / sum;
  std::stable_sort(parts.begin(), parts.end(),
                   [](const RigidPart& a, const RigidPart& b) { return a.weight > b.weight; });
  MassProperties others;
  for (std::size_t i = 1; i < parts.size(); ++i) {
    DraftBody& body = parts[i].body;
    const MassProperties solid = solid_body(body, parts[i].weight);
    if (const std::string problem = set_mass(solid, body, account); !problem.empty()) return problem;
    others = others + in_world(solid, body.pose);
  }
  DraftBody& heaviest = parts[0].body;
  const MassProperties rest = whole - others, uniform = in_world(solid_body(heaviest, parts[0].weight), heaviest.pose);
  // Round bodies keep their surface if it costs no more than rounding.
  const double size = radius_of(heaviest);
  const bool same = norm(rest.centre - uniform.centre) <= 1e-9 * size &&
                    largest_difference(rest.inertia, uniform.inertia) <= 1e-9 * trace(whole.inertia);
  const bool round = heaviest.shape == DraftShape::kSphere || heaviest.shape == DraftShape::kCapsule;
  std::string how = "together exactly its mass, centre and moments";
  DraftBody tried = heaviest;
  if (same) {
    if (const std::string problem = set_mass(in_frame(uniform, heaviest.pose), heaviest, account); !problem.empty())
      return problem;
  } else if (!round && is_a_body(rest) && set_mass(in_frame(rest, heaviest.pose), tried, account).empty()) {
    heaviest = std::move(tried);
  } else {
    const MassProperties total = others + uniform;
    double reach = 0;
    for (const RigidPart& part : parts)
      reach = std::max(reach, norm(part.body.pose.position - whole.centre) + radius_of(part.body));
    const double centre = norm(total.centre - whole.centre) / reach;
    const double moments = largest_difference(total.inertia, whole.inertia) / trace(whole.inertia);
    if (std::max(centre, moments) > kMostMassError)
      return fmt::format(
          "its shapes cannot have its centre of mass and moments: off by {:.2g} % of its size and {:.2g} % "
          "of its moments",
          100 * centre, 100 * moments);
    if (const std::string problem = set_mass(in_frame(uniform, heaviest.pose), heaviest, account); !problem.empty())
      return problem;
    how = fmt::format("its mass exactly, its centre to {:.2g} % of its size, its moments to {:.2g} %", 100 * centre,
                      100 * moments);
  }
  account.change(fmt::format("{}: {} shapes, so {} bodies held to each other by fixed joints, which give a little: {}",
                             label, parts.size(), parts.size(), how));
  return {};
}

void RigidGroup::set_velocity(const Twistd& twist, const Vec3d& at) {
  for (RigidPart& part : parts) {
    DraftBody& body = part.body;
    const Vec3d own = body.centre.value_or(Vec3d{});
    const Vec3d centre = body.pose.position + rotate(body.pose.rotation, own);
    body.velocity = {twist.linear + cross(twist.angular, centre - at), twist.angular};
    if (kinematic) body.role = DraftRole::kKinematic;
  }
}

std::vector<std::string> RigidGroup::names() const {
  std::vector<std::string> list;
  for (const RigidPart& part : parts) list.push_back(part.body.name);
  return list;
}

void RigidGroup::add_to(SceneDraft& draft, unsigned& guards) const {
  for (const RigidPart& part : parts) draft.bodies.push_back(part.body);
  if (kinematic) return;
  for (std::size_t i = 1; i < parts.size(); ++i) {
    DraftJoint weld;
    weld.kind = "fixed";
    weld.a = parts[0].body.name;
    weld.b = parts[i].body.name;
    weld.origin = "one body in the model";
    weld.position = parts[i].body.pose.position;
    draft.joints.push_back(std::move(weld));
    for (std::size_t k = 1; k < i; ++k) {
      const DraftBody &a = parts[k].body, &b = parts[i].body;
      if (norm(a.pose.position - b.pose.position) > radius_of(a) + radius_of(b) + kNearby_m) continue;
      DraftJoint rope;
      rope.kind = "distance";
      rope.a = a.name;
      rope.b = b.name;
      rope.origin = "keeps them from colliding, nothing else";
      rope.low = 0;
      rope.high = kNeverReached_m;
      draft.joints.push_back(std::move(rope));
      ++guards;
    }
  }
}

}  // namespace tactus::scene_import
