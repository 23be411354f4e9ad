#include "sim/loader/scene_load_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace tactus::sim {
namespace {

using physics::Body;
using physics::Shape;
using physics::ShapeKind;

// Ranges of lengths and masses whose squares and inverses are far from the limits of a double, and of a float.
constexpr text::Range kLength{"a length", 1e-4, 1e3};
constexpr text::Range kMass{"a mass", 1e-6, 1e6};
constexpr double kLeastInertia = 1e-18, kLargestInertia = 1e12;  // kg m^2
constexpr double kFar = 1e3;                                     // m
constexpr text::Range kDensity{"a density", 1e-3, 1e5};
constexpr text::Range kVelocity{"a velocity", -100, 100};
constexpr text::Range kAngularVelocity{"an angular velocity", -1000, 1000};

// A shape, and the pose of its frame in the frame of the body's keys: hulls and meshes may be given in any frame.
struct ReadShape {
  Shape shape;
  Posed given_from_body{};
  const physics::Hull* hull{nullptr};
  std::optional<HullOfBody> made{};  // of a hull

  double volume() const { return hull != nullptr ? hull->volume : physics::volume_of(shape); }
};

// Empty if the shape is unknown: a mistake has been added, and the other keys cannot be checked.
std::optional<ReadShape> read_shape(text::TableReader& table, BodyRole role, HullReader& hulls, MeshReader& meshes) {
  const bool proxy = role == BodyRole::kProxy;
  if (!table.require("shape", proxy ? "sphere, capsule, box, hull" : "box, sphere, capsule, hull, plane, mesh"))
    return std::nullopt;
  const std::string word = proxy ? table.word("shape", "", {"sphere", "capsule", "box", "hull"})
                                 : table.word("shape", "", {"box", "sphere", "capsule", "hull", "plane", "mesh"});
  if (word.empty()) return std::nullopt;
  if (word == "plane") return ReadShape{Shape::plane()};
  if (word == "hull") {
    const auto made = hulls.read(table);
    if (!made) return std::nullopt;
    const auto& hull = hulls.hull(made->index);
    return ReadShape{Shape::convex(hull, made->index), made->given_from_body, &hull, made};
  }
  if (word == "mesh") {
    const auto made = meshes.read(table);
    if (!made) return std::nullopt;
    return ReadShape{Shape::mesh(meshes.mesh(made->index).half_extents, made->index), made->given_from_body};
  }
  if (word == "box") {
    table.require("size_m", "[x, y, z]: the full lengths of the edges");
    return ReadShape{Shape::box(0.5 * table.vector("size_m", {0.1, 0.1, 0.1}, kLength))};
  }
  table.require("radius_m", "a number");
  const double radius = table.number("radius_m", 0.05, kLength);
  if (word == "sphere") return ReadShape{Shape::sphere(radius)};
  table.require("length_m", "a number: from the centre of one cap to that of the other");
  return ReadShape{Shape::capsule(radius, 0.5 * table.number("length_m", 0.1, kLength))};
}

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

// The moments of inertia in a body's table, about its centre of mass along the axes of its frame; empty where there are
// none or they are no rigid body's.
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
  const double room = 1e-9 * half;
  const double minor = (a + room) * (b + room) - m[3] * m[3];
  const double determinant = (a + room) * ((b + room) * (c + room) - m[5] * m[5]) -
                             m[3] * (m[3] * (c + room) + m[5] * m[4]) - m[4] * (m[3] * m[5] + (b + room) * m[4]);
  if (std::min({m[0], m[1], m[2]}) >= kLeastInertia && std::min({a, b, c}) >= -room && minor >= 0 && determinant >= 0)
    return inertia;
  table.mistake("inertia_kg_m2", "no rigid body has these moments of inertia",
                fmt::format("moments >= {:g}, none of them larger than the sum of the other two", kLeastInertia));
  return std::nullopt;
}

// Sets what the body has instead of a homogeneous solid's mass properties; a hull then becomes one with these.
void read_mass_properties(text::TableReader& table, HullReader& hulls, const ReadShape& known, Body& body) {
  const auto inertia = read_inertia(table);
  if (known.hull == nullptr) {
    if (!inertia) return;
    if (inertia->xy != 0 || inertia->xz != 0 || inertia->yz != 0)
      table.mistake("inertia_kg_m2", "turned axes of inertia need a hull", "[xx, yy, zz]; or shape = \"hull\"");
    body.inertia = {inertia->xx, inertia->yy, inertia->zz};
    return;
  }
  const Vec3d centre =
      table.vector("centre_of_mass_m", known.given_from_body.position, {"a place of the centre", -kFar, kFar});
  if (!inertia) {
    body.inertia = known.hull->inertia_per_kg * body.mass;
    if (table.has("centre_of_mass_m") && !table.has("inertia_kg_m2"))
      table.mistake("centre_of_mass_m", "there are no moments of inertia about it", "inertia_kg_m2 as well");
    return;
  }
  const double per_kg = 1 / body.mass;
  const SymMat3d scaled{inertia->xx * per_kg, inertia->yy * per_kg, inertia->zz * per_kg,
                        inertia->xy * per_kg, inertia->xz * per_kg, inertia->yz * per_kg};
  const auto made = hulls.with_mass(*known.made, centre, scaled);
  if (!made) {
    table.mistake("centre_of_mass_m", "is not inside the hull", "a place inside it");
    return;
  }
  const physics::Hull& hull = hulls.hull(made->index);
  body.shape = Shape::convex(hull, made->index);
  body.inertia = hull.inertia_per_kg * body.mass;
  body.motion.pose = table.pose() * made->given_from_body;
}

Vec3d read_edges(text::TableReader& table, const char* key, const Vec3d& fallback) {
  return table.vector(key, fallback, {"a size", kLength.low, kLength.high});
}

// --- the generators' own keys. Each fills the bodies if they fit in `capacity`.

template <class Spec, class Make>
void make_if_it_fits(text::TableReader& table, const Spec& spec, Make make, unsigned capacity, Generated& made) {
  const unsigned count = count_of(spec);
  if (count > capacity) {
    table.mistake("kind", fmt::format("makes {} bodies", count),
                  fmt::format("{} more: a scene has at most {}", capacity, kMaxSceneBodies));
    return;
  }
  made.bodies = make(spec);
}

void read_wall(text::TableReader& table, double friction, unsigned capacity, Generated& made) {
  WallSpec spec;
  spec.columns = table.count("columns", spec.columns, {"a number of bricks", 2, 1000});
  spec.rows = table.count("rows", spec.rows, {"a number of courses", 1, 1000});
  spec.brick_m = read_edges(table, "brick_m", spec.brick_m);
  spec.gap_m = table.number("gap_m", spec.gap_m, {"a gap", 0, 1});
  spec.mass_kg = table.number("mass_kg", spec.mass_kg, kMass);
  spec.friction = friction;
  if (spec.gap_m > 0.2 * spec.brick_m.x) {
    table.mistake("gap_m", fmt::format("{} is too wide for bricks of {} m", spec.gap_m, spec.brick_m.x),
                  "at most a fifth of a brick");
    return;
  }
  make_if_it_fits(table, spec, make_wall, capacity, made);
}

void read_pile(text::TableReader& table, double friction, unsigned capacity, Generated& made) {
  PileSpec spec;
  spec.count = table.count("count", spec.count, {"a number of cubes", 1, kMaxSceneBodies});
  spec.layers = table.count("layers", spec.layers, {"a number of layers", 1, 100});
  spec.cube_m = table.number("cube_m", spec.cube_m, kLength);
  spec.gap_fraction = table.number("gap_fraction", spec.gap_fraction, {"a gap between cubes", 0, 0.2});
  spec.mass_kg = table.number("mass_kg", spec.mass_kg, kMass);
  spec.wall_height_m = table.number("wall_height_m", spec.cube_m * (spec.layers + 2), kLength);
  spec.wall_thickness_m = table.number("wall_thickness_m", spec.cube_m, kLength);
  spec.seed = table.seed("seed", spec.seed);
  spec.friction = friction;
  make_if_it_fits(table, spec, make_pile, capacity, made);
}

void read_tower(text::TableReader& table, double friction, unsigned capacity, Generated& made) {
  TowerSpec spec;
  spec.layers = table.count("layers", spec.layers, {"a number of layers", 1, 1000});
  spec.blocks_per_layer = table.count("blocks_per_layer", spec.blocks_per_layer, {"a number of blocks", 1, 100});
  spec.block_m = read_edges(table, "block_m", spec.block_m);
  spec.mass_kg = table.number("mass_kg", spec.mass_kg, kMass);
  spec.friction = friction;
  make_if_it_fits(table, spec, make_tower, capacity, made);
}

void read_card_house(text::TableReader& table, double friction, unsigned capacity, Generated& made) {
  CardHouseSpec spec;
  spec.levels = table.count("levels", spec.levels, {"a number of levels", 1, 50});
  spec.card_m = read_edges(table, "card_m", spec.card_m);
  spec.angle_rad = table.number("angle_rad", spec.angle_rad, {"an angle from the vertical", 0.02, 0.7});
  spec.gap_m = table.number("gap_m", spec.gap_m, {"a gap", 0, 0.1});
  spec.mass_kg = table.number("mass_kg", spec.mass_kg, kMass);
  spec.friction = friction;
  const auto [s, c] = sin_cos(spec.angle_rad);
  const double pair_width = 2 * (spec.card_m.y * s + spec.card_m.z * c), pitch = spec.card_m.x + spec.gap_m;
  if (pair_width > pitch) {
    table.mistake("angle_rad", fmt::format("a pair of cards is {:.4g} m wide there", pair_width),
                  fmt::format("at most {:.4g} m: a smaller angle, or a wider card", pitch));
    return;
  }
  if (spec.gap_m > spec.card_m.z * c) {
    table.mistake("gap_m", fmt::format("flat cards {} m apart have nothing to rest on", spec.gap_m),
                  fmt::format("at most {:.4g}: half the width of a pair's top", spec.card_m.z * c));
    return;
  }
  auto needs = needs_of(spec);
  made.part.foot_friction = std::move(needs.foot_friction);
  made.part.top_friction = needs.top_friction;
  make_if_it_fits(table, spec, make_card_house, capacity, made);
}

void read_domino_row(text::TableReader& table, double friction, unsigned capacity, Generated& made) {
  DominoRowSpec spec;
  spec.count = table.count("count", spec.count, {"a number of dominoes", 1, kMaxSceneBodies});
  spec.domino_m = read_edges(table, "domino_m", spec.domino_m);
  spec.spacing_m = table.number("spacing_m", spec.spacing_m, kLength);
  spec.mass_kg = table.number("mass_kg", spec.mass_kg, kMass);
  spec.friction = friction;
  if (spec.spacing_m < spec.domino_m.x) {
    table.mistake("spacing_m", fmt::format("{} m is less than a domino's thickness", spec.spacing_m),
                  fmt::format("a number >= {}", spec.domino_m.x));
    return;
  }
  make_if_it_fits(table, spec, make_domino_row, capacity, made);
}

// Copies the part in a grid centred on its pose: row by row, each copy's bodies together.
void repeat(text::TableReader& table, unsigned capacity, Generated& made) {
  const unsigned columns = table.count("copies_x", 1, {"a number of copies", 1, 1000});
  const unsigned rows = table.count("copies_y", 1, {"a number of copies", 1, 1000});
  const double pitch_m = table.number("copy_pitch_m", 1, kLength);
  const std::size_t count = std::size_t{columns} * rows;
  if (count == 1) return;
  if (count * made.bodies.size() > capacity) {
    table.mistake("copies_x", fmt::format("{} copies make {} bodies", count, count * made.bodies.size()),
                  fmt::format("{} more: a scene has at most {}", capacity, kMaxSceneBodies));
    made.bodies.clear();
    return;
  }
  const Bodies one = std::move(made.bodies);
  made.bodies.clear();
  made.bodies.reserve(count * one.size());
  for (unsigned j = 0; j < rows; ++j)
    for (unsigned i = 0; i < columns; ++i)
      for (auto body : one) {
        body.motion.pose.position += pitch_m * Vec3d{i - 0.5 * (columns - 1), j - 0.5 * (rows - 1), 0};
        made.bodies.push_back(body);
      }
}

}  // namespace

Body read_body(text::TableReader& table, BodyRole role, HullReader& hulls, MeshReader& meshes) {
  auto known_shape = read_shape(table, role, hulls, meshes);
  if (!known_shape) {
    table.ignore_the_rest();
    return physics::make_dynamic_body(kNoBody, Shape::sphere(0.05), 1.0, 0.0, Posed{});
  }
  const Shape& shape = known_shape->shape;
  const double friction = table.number("friction", 0, kFriction);
  const Posed pose = table.pose() * known_shape->given_from_body;
  const bool is_plane = shape.kind == ShapeKind::kPlane, is_mesh = shape.kind == ShapeKind::kMesh;
  const bool fixed = role == BodyRole::kBody && table.flag("fixed", is_plane || is_mesh);
  if (is_plane && !fixed) table.mistake("fixed", "a plane never moves", "true");
  if (is_mesh && !fixed) table.mistake("fixed", "a mesh never moves", "true; what moves is a hull, or several bodies");
  if (fixed || is_plane || is_mesh) {
    for (const char* key : {"mass_kg", "density_kg_per_m3", "inertia_kg_m2", "centre_of_mass_m", "velocity_m_per_s",
                            "angular_velocity_rad_per_s"})
      table.refuse(key, is_mesh ? "a mesh never moves, so it has none" : "a fixed body has none",
                   is_mesh ? "no such key; what moves is a hull, or several bodies" : "no such key");
    return physics::make_fixed_body(kNoBody, shape, friction, pose);
  }
  // The mass of a scripted body has no effect, so it may be omitted.
  const bool weightless = role == BodyRole::kBody && table.flag("kinematic", false) && !table.has("mass_kg") &&
                          !table.has("density_kg_per_m3");
  const double mass_kg = weightless ? 1 : read_mass(table, known_shape->volume());
  auto body = physics::make_dynamic_body(kNoBody, shape, mass_kg, friction, pose);
  read_mass_properties(table, hulls, *known_shape, body);
  body.motion.velocity.linear = table.vector("velocity_m_per_s", {}, kVelocity);
  body.motion.velocity.angular = table.vector("angular_velocity_rad_per_s", {}, kAngularVelocity);
  if (role == BodyRole::kProxy) body.gravity_scale = 0;
  return body;
}

Generated read_generator(text::TableReader& table, unsigned capacity) {
  Generated made;
  const auto kinds = {"wall", "pile", "tower", "card_house", "domino_row"};
  if (!table.require("kind", "wall, pile, tower, card_house, domino_row")) return made;
  const std::string kind = table.word("kind", "", kinds);
  if (kind.empty()) return made;  // its keys are unknown and not checked
  const double friction = table.number("friction", 0, kFriction);
  const Posed world_from_part = table.pose();
  made.part.kind = kind;
  made.part.friction = friction;
  if (kind == "wall") read_wall(table, friction, capacity, made);
  if (kind == "pile") read_pile(table, friction, capacity, made);
  if (kind == "tower") read_tower(table, friction, capacity, made);
  if (kind == "card_house") read_card_house(table, friction, capacity, made);
  if (kind == "domino_row") read_domino_row(table, friction, capacity, made);
  repeat(table, capacity, made);
  for (auto& body : made.bodies) body.motion.pose = world_from_part * body.motion.pose;
  made.part.count = static_cast<unsigned>(made.bodies.size());
  table.finish();
  return made;
}

}  // namespace tactus::sim
