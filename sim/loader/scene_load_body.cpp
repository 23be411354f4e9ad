#include "sim/loader/scene_load_body.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sim/loader/scene_load.h"
#include "sim/loader/scene_load_ranges.h"

namespace tactus::sim {
namespace {

using physics::Body;
using physics::Shape;
using physics::ShapeKind;
using physics::ShapeTraits;

constexpr double kLeastInertia = 1e-18, kLargestInertia = 1e12;  // kg m^2
constexpr double kFar = 1e3;                                     // m
constexpr text::Range kDensity{"a density", 1e-3, 1e5};
constexpr text::Range kVelocity{"a velocity", -100, 100};
constexpr text::Range kAngularVelocity{"an angular velocity", -1000, 1000};

constexpr const char* kCentre = "centre_of_mass_m";
constexpr const char* kInertia = "inertia_kg_m2";

double read_mass(text::TableReader& table, double volume_m3) {
  const double mass = table.number("mass_kg", 1, kMass), density = table.number("density_kg_per_m3", 1000, kDensity);
  if (table.has("mass_kg") && table.has("density_kg_per_m3"))
    table.mistake("density_kg_per_m3", "there is a mass already", "mass_kg or density_kg_per_m3");
  if (!table.has("density_kg_per_m3")) {
    table.require("mass_kg", "mass_kg or density_kg_per_m3");
    return mass;
  }
  const double from_density = density * volume_m3;
  if (from_density >= kMass.low && from_density <= kMass.high) return from_density;
  table.mistake("density_kg_per_m3", fmt::format("gives a mass of {:g} kg", from_density),
                fmt::format("a mass >= {:g} and <= {:g}", kMass.low, kMass.high));
  return 1;
}

// The moments of inertia in a body's table [kg m^2], about its centre of mass, along the axes of its frame. Empty if
// the table has none, or if no rigid body can have them, which is reported.
std::optional<SymMat3d> read_inertia(text::TableReader& table) {
  const auto list = table.array("inertia_kg_m2", 6);
  if (!table.has("inertia_kg_m2")) return std::nullopt;
  const char* accepted = "[xx, yy, zz] or [xx, yy, zz, xy, xz, yz], about the centre of mass";
  double m[6]{};
  for (std::size_t i = 0; i < list.size(); ++i) m[i] = list[i].number;
  const bool are_numbers = std::all_of(list.begin(), list.end(), [](const text::TomlNode& node) {
    const bool number = node.kind == text::TomlKind::kNumber || node.kind == text::TomlKind::kInteger;
    return number && std::abs(node.number) <= kLargestInertia;
  });
  if ((list.size() != 3 && list.size() != 6) || !are_numbers) {
    table.mistake("inertia_kg_m2", "is no list of moments of inertia", accepted);
    return std::nullopt;
  }
  const SymMat3d inertia{m[0], m[1], m[2], m[3], m[4], m[5]};
  // The second moment of the mass, the integral of x x^T, is positive semidefinite: its leading minors are not
  // negative, within rounding.
  const double half = 0.5 * (m[0] + m[1] + m[2]), a = half - m[0], b = half - m[1], c = half - m[2];
  const double rounding = 1e-9 * half;
  const double minor = (a + rounding) * (b + rounding) - m[3] * m[3];
  const double determinant = (a + rounding) * ((b + rounding) * (c + rounding) - m[5] * m[5]) -
                             m[3] * (m[3] * (c + rounding) + m[5] * m[4]) -
                             m[4] * (m[3] * m[5] + (b + rounding) * m[4]);
  if (std::min({m[0], m[1], m[2]}) >= kLeastInertia && std::min({a, b, c}) >= -rounding && minor >= 0 &&
      determinant >= 0)
    return inertia;
  table.mistake("inertia_kg_m2", "no rigid body has these moments of inertia",
                fmt::format("moments >= {:g}, none of them larger than the sum of the other two", kLeastInertia));
  return std::nullopt;
}

// Adds a mistake for each key of mass or velocity: a fixed body has neither.
void refuse_mass_and_motion(text::TableReader& table, const char* what, const char* accepted) {
  for (const char* key :
       {"mass_kg", "density_kg_per_m3", kInertia, kCentre, "velocity_m_per_s", "angular_velocity_rad_per_s"})
    table.refuse(key, what, accepted);
}

// The mass of a scripted body has no effect, so it may be omitted.
bool is_weightless(text::TableReader& table, BodyRole role) {
  return role == BodyRole::kBody && table.flag("kinematic", false) && !table.has("mass_kg") &&
         !table.has("density_kg_per_m3");
}

// The word of a shape that `fits`; empty if it is missing or none of these: a mistake has been added.
template <class Fits>
std::optional<ShapeKind> read_kind(text::TableReader& table, const Fits& fits) {
  std::vector<std::string_view> names;
  for (const ShapeKind kind : physics::kShapeKinds)
    if (fits(traits_of(kind))) names.push_back(traits_of(kind).name);
  return find_choice(physics::kShapeKinds, table.required_word("shape", names));
}

double read_radius(text::TableReader& table) {
  table.require("radius_m", "a number");
  return table.number("radius_m", 0.05, kLength);
}

double read_half_length(text::TableReader& table, const char* from_where) {
  table.require("length_m", fmt::format("a number: {}", from_where).c_str());
  return 0.5 * table.number("length_m", 0.1, kLength);
}

Body harmless_body() { return physics::make_dynamic_body(kNoBody, Shape::sphere(0.05), 1.0, 0.0, Posed{}); }

}  // namespace

void BodyReader::read_kept(text::TableReader& root) {
  hulls_.read_kept(root.array("hull_file", kMaxSceneHulls));
  meshes_.read_kept(root.array("mesh_file", kMaxSceneBodies));
}

double BodyReader::volume_of(const Shape& shape) const {
  return shape.kind == ShapeKind::kHull ? scene_.hulls[shape.index].volume : physics::volume_of(shape);
}

Vec3d BodyReader::inertia_of(const Shape& shape, double mass_kg) const {
  return shape.kind == ShapeKind::kHull ? scene_.hulls[shape.index].inertia_per_kg * mass_kg
                                        : physics::inertia_of(shape, mass_kg);
}

// A shape of one body. Empty if a file or points of it are wrong: a mistake has been added.
std::optional<ReadShape> BodyReader::read_shape(text::TableReader& table, ShapeKind kind) {
  switch (kind) {
    case ShapeKind::kSphere:
      return ReadShape{Shape::sphere(read_radius(table))};
    case ShapeKind::kCapsule: {
      const double radius = read_radius(table);
      return ReadShape{
          Shape::capsule(radius, read_half_length(table, "from the centre of one cap to that of the other"))};
    }
    case ShapeKind::kCylinder: {
      const double radius = read_radius(table);
      return ReadShape{Shape::cylinder(radius, read_half_length(table, "from one end to the other"))};
    }
    case ShapeKind::kCone: {  // the keys' frame has its origin in the middle of the base
      const double radius = read_radius(table), half_length = read_half_length(table, "from one end to the other");
      return ReadShape{Shape::cone(radius, half_length), {{0, 0, 0.5 * half_length}, {}}};
    }
    case ShapeKind::kBox:
      table.require("size_m", "[x, y, z]: the full lengths of the edges");
      return ReadShape{Shape::box(0.5 * table.vector("size_m", {0.1, 0.1, 0.1}, kLength))};
    case ShapeKind::kHull: {
      const auto made = hulls_.read(table);
      if (!made) return std::nullopt;
      return ReadShape{Shape::convex(hulls_.hull(made->index), made->index), made->given_from_body, made};
    }
    case ShapeKind::kPlane:
      return ReadShape{Shape::plane()};
    case ShapeKind::kMesh: {
      const auto made = meshes_.read(table);
      if (!made) return std::nullopt;
      return ReadShape{Shape::mesh(meshes_.mesh(made->index).half_extents, made->index), made->given_from_body};
    }
    case ShapeKind::kCompound:  // read_compound
      return std::nullopt;
  }
  return std::nullopt;
}

// Replaces the mass properties of a homogeneous solid by the moments of inertia and the centre of mass in the table, if
// there are any. A hull is replaced by an entry with these properties.
void BodyReader::read_mass_properties(text::TableReader& table, const ReadShape& known, ReadBody& read) {
  Body& body = read.body;
  const auto inertia = read_inertia(table);
  if (!known.hull) {
    if (!inertia) return;
    if (inertia->xy != 0 || inertia->xz != 0 || inertia->yz != 0)
      table.mistake(kInertia, "turned axes of inertia need a hull or a compound",
                    "[xx, yy, zz]; or shape = \"hull\" or \"compound\"");
    body.inertia = {inertia->xx, inertia->yy, inertia->zz};
    return;
  }
  const Vec3d centre = table.vector(kCentre, known.given_from_body.position, {"a place of the centre", -kFar, kFar});
  if (!inertia) {
    body.inertia = inertia_of(known.shape, body.mass);
    if (table.has(kCentre) && !table.has(kInertia))
      table.mistake(kCentre, "there are no moments of inertia about it", "inertia_kg_m2 as well");
    return;
  }
  const double per_kg = 1 / body.mass;
  const SymMat3d scaled{inertia->xx * per_kg, inertia->yy * per_kg, inertia->zz * per_kg,
                        inertia->xy * per_kg, inertia->xz * per_kg, inertia->yz * per_kg};
  const auto made = hulls_.with_mass(*known.hull, centre, scaled);
  if (!made) {
    table.mistake(kCentre, "is not inside the hull", "a place inside it");
    return;
  }
  const physics::Hull& hull = hulls_.hull(made->index);
  body.shape = Shape::convex(hull, made->index);
  body.inertia = hull.inertia_per_kg * body.mass;
  body.motion.pose = table.pose() * made->given_from_body;
  read.given_from_body = made->given_from_body;
}

void BodyReader::read_motion(text::TableReader& table, Body& body) {
  body.motion.velocity.linear = table.vector("velocity_m_per_s", {}, kVelocity);
  body.motion.velocity.angular = table.vector("angular_velocity_rad_per_s", {}, kAngularVelocity);
}

ReadBody BodyReader::read(text::TableReader& table, BodyRole role) {
  const bool proxy = role == BodyRole::kProxy;
  const auto kind = read_kind(table, [proxy](const ShapeTraits& traits) { return traits.moves || !proxy; });
  if (kind == ShapeKind::kCompound) return read_compound(table, role);
  const auto known = kind ? read_shape(table, *kind) : std::nullopt;
  if (!known) {  // its other keys cannot be checked
    table.ignore_the_rest();
    return {harmless_body()};
  }
  table.refuse("parts", fmt::format("a {} has none", traits_of(*kind).name), "no such key; or shape = \"compound\"");
  const Shape& shape = known->shape;
  const double friction = table.number("friction", 0, kFriction);
  const Posed pose = table.pose() * known->given_from_body;
  const bool is_plane = shape.kind == ShapeKind::kPlane, is_mesh = shape.kind == ShapeKind::kMesh;
  const bool fixed = !proxy && table.flag("fixed", is_plane || is_mesh);
  if (is_plane && !fixed) table.mistake("fixed", "a plane never moves", "true");
  if (is_mesh && !fixed) table.mistake("fixed", "a mesh never moves", "true; what moves is a hull or a compound");
  if (fixed || is_plane || is_mesh) {
    refuse_mass_and_motion(table, is_mesh ? "a mesh never moves, so it has none" : "a fixed body has none",
                           is_mesh ? "no such key; what moves is a hull or a compound" : "no such key");
    return {physics::make_fixed_body(kNoBody, shape, friction, pose), known->given_from_body};
  }
  const double mass_kg = is_weightless(table, role) ? 1 : read_mass(table, volume_of(shape));
  ReadBody read{physics::make_dynamic_body(kNoBody, shape, mass_kg, friction, pose), known->given_from_body};
  read_mass_properties(table, *known, read);
  read_motion(table, read.body);
  if (proxy) read.body.gravity_scale = 0;
  return read;
}

// Empty if a part's shape is unknown: a mistake has been added. Masses are those of the density 1 kg/m^3, unless the
// parts have their own.
std::vector<GivenPart> BodyReader::read_parts(text::TableReader& table, MassFrom mass_from) {
  std::vector<GivenPart> parts;
  const std::size_t mistakes = diagnostics_.mistakes.size();
  const auto nodes = table.array("parts", kMaxParts);
  const bool is_list = diagnostics_.mistakes.size() == mistakes;
  if (table.require("parts", "[[body.parts]] tables: the shapes that the body has") && is_list && nodes.empty())
    table.mistake("parts", "are none", fmt::format("1 to {} parts", kMaxParts));
  bool known_all = !nodes.empty();
  unsigned number = 0;
  for (const text::TomlNode& node : nodes) {
    text::TableReader t(&node, fmt::format("{}.{}", table.name_of("parts"), ++number), diagnostics_);
    if (!t.there()) {
      known_all = false;
      continue;
    }
    const auto kind = read_kind(t, [](const ShapeTraits& traits) { return traits.is_part; });
    const auto known = kind ? read_shape(t, *kind) : std::nullopt;
    if (!known) {
      t.ignore_the_rest();
      known_all = false;
      continue;
    }
    GivenPart part{.shape = known->shape,
                   .given_from_part = t.pose() * known->given_from_body,
                   .mass_kg = volume_of(known->shape),
                   .inertia_kg_m2 = {}};
    if (mass_from == MassFrom::kParts) {
      part.mass_kg = read_mass(t, volume_of(known->shape));
    } else {
      const bool none = mass_from == MassFrom::kNothing;
      for (const char* key : {"mass_kg", "density_kg_per_m3"})
        t.refuse(key, none ? "the body has no mass" : "the body has a mass already",
                 none ? "no such key" : "the body's mass, or one of each part");
    }
    parts.push_back(part);
    t.finish();
  }
  return known_all ? parts : std::vector<GivenPart>();
}

// Shares the body's mass among the parts by volume, if they have none of their own.
void BodyReader::share_mass(text::TableReader& table, MassFrom mass_from, std::vector<GivenPart>& parts) {
  double volume = 0;
  for (const GivenPart& part : parts) volume += volume_of(part.shape);
  const double mass_kg = mass_from == MassFrom::kBody ? read_mass(table, volume) : 1;
  for (GivenPart& part : parts) {
    if (mass_from != MassFrom::kParts) part.mass_kg *= mass_kg / volume;
    part.inertia_kg_m2 = inertia_of(part.shape, part.mass_kg);
  }
}

// Returns the shape of a compound that the scene already has, if parts and inertia are equal; else of a new one.
Shape BodyReader::add_compound(const BuiltCompound& built) {
  const auto is_same = [&](const physics::Compound& other) {
    return other.inertia_per_kg == built.compound.inertia_per_kg &&
           std::equal(other.parts.begin(), other.parts.end(), built.compound.parts.begin(), built.compound.parts.end());
  };
  const auto known = std::find_if(scene_.compounds.begin(), scene_.compounds.end(), is_same);
  const auto index = static_cast<std::uint32_t>(known - scene_.compounds.begin());
  if (known == scene_.compounds.end()) {
    scene_.compounds.push_back(built.compound);
    scene_.shape_data.push_back(built.parts);
  }
  return physics::compound_shape(scene_.compounds[index], index);
}

ReadBody BodyReader::read_compound(text::TableReader& table, BodyRole role) {
  const bool proxy = role == BodyRole::kProxy;
  const bool fixed = !proxy && table.flag("fixed", false);
  const bool own_mass = table.has("mass_kg") || table.has("density_kg_per_m3");
  const MassFrom mass_from = fixed || is_weightless(table, role) ? MassFrom::kNothing
                             : own_mass                          ? MassFrom::kBody
                                                                 : MassFrom::kParts;
  const double friction = table.number("friction", 0, kFriction);
  const Posed given = table.pose();
  auto parts = read_parts(table, mass_from);
  if (parts.empty()) {
    table.ignore_the_rest();
    return {harmless_body()};
  }
  share_mass(table, mass_from, parts);
  auto built = build_compound(parts, scene_.hulls);
  if (fixed) {
    refuse_mass_and_motion(table, "a fixed body has none", "no such key");
  } else {
    const Vec3d centre = table.vector(kCentre, built.given_from_body.position, {"a place of the centre", -kFar, kFar});
    if (const auto inertia = read_inertia(table))
      built = build_compound(parts, scene_.hulls, GivenMass{centre, *inertia});
    else if (table.has(kCentre) && !table.has(kInertia))
      table.mistake(kCentre, "there are no moments of inertia about it", "inertia_kg_m2 as well");
  }
  const Shape shape = add_compound(built);
  const Posed pose = given * built.given_from_body;
  if (fixed) return {physics::make_fixed_body(kNoBody, shape, friction, pose), built.given_from_body};
  auto body = physics::make_dynamic_body(kNoBody, shape, built.mass_kg, friction, pose);
  body.inertia = built.inertia_kg_m2;
  read_motion(table, body);
  if (proxy) body.gravity_scale = 0;
  return {body, built.given_from_body};
}

}  // namespace tactus::sim
