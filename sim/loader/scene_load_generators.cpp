#include "sim/loader/scene_load_generators.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/loader/scene_load_ranges.h"

namespace tactus::sim {
namespace {

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

struct Generator {
  std::string_view name;
  void (*read)(text::TableReader& table, double friction, unsigned capacity, Generated& made);
};

constexpr std::array kGenerators{Generator{"wall", read_wall}, Generator{"pile", read_pile},
                                 Generator{"tower", read_tower}, Generator{"card_house", read_card_house},
                                 Generator{"domino_row", read_domino_row}};

}  // namespace

std::vector<std::string_view> generator_names() {
  std::vector<std::string_view> names;
  for (const Generator& generator : kGenerators) names.push_back(generator.name);
  return names;
}

Generated read_generator(text::TableReader& table, unsigned capacity) {
  Generated made;
  const std::string kind = table.required_word("kind", generator_names());
  if (kind.empty()) return made;  // its keys are unknown and not checked
  const double friction = table.number("friction", 0, kFriction);
  const Posed world_from_part = table.pose();
  made.part.kind = kind;
  made.part.friction = friction;
  for (const Generator& generator : kGenerators)
    if (generator.name == kind) generator.read(table, friction, capacity, made);
  repeat(table, capacity, made);
  for (auto& body : made.bodies) body.motion.pose = world_from_part * body.motion.pose;
  made.part.count = static_cast<unsigned>(made.bodies.size());
  table.finish();
  return made;
}

}  // namespace tactus::sim
