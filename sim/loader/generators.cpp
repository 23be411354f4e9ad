#include "sim/loader/generators.h"

#include <algorithm>

#include "sim/random.h"

namespace tactus::sim {
namespace {

using physics::Body;
using physics::Shape;

Body box(const Vec3d& size_m, double mass_kg, double friction, const Vec3d& centre, const Quatd& rotation = {}) {
  return physics::make_dynamic_body(kNoBody, Shape::box(0.5 * size_m), mass_kg, friction, Posed{centre, rotation});
}

Quatd about_z(double angle_rad) { return quat_from_rotation_vector(Vec3d{0, 0, angle_rad}); }

// Layout of a pile's layers: columns along x, rows along y, of the smallest nearly square layer that has the cubes.
struct PileLayout {
  unsigned columns, rows;
  double pitch_m, shift_m;
};

PileLayout layout_of(const PileSpec& spec) {
  const unsigned per_layer = (spec.count + spec.layers - 1) / spec.layers;
  unsigned columns = 1;
  while (columns * columns < per_layer) ++columns;
  const unsigned rows = (per_layer + columns - 1) / columns;
  return {.columns = columns,
          .rows = rows,
          .pitch_m = spec.cube_m * (1 + spec.gap_fraction),
          .shift_m = 0.25 * spec.cube_m};
}

}  // namespace

unsigned count_of(const WallSpec& spec) noexcept { return spec.rows * spec.columns + spec.rows / 2; }

Bodies make_wall(const WallSpec& spec) {
  Bodies bodies;
  bodies.reserve(count_of(spec));
  const double pitch = spec.brick_m.x + spec.gap_m, length = pitch * spec.columns;
  const Vec3d half_brick{0.5 * (spec.brick_m.x - spec.gap_m), spec.brick_m.y, spec.brick_m.z};
  const double half_mass = spec.mass_kg * half_brick.x / spec.brick_m.x;
  for (unsigned row = 0; row < spec.rows; ++row) {
    const double z = (row + 0.5) * spec.brick_m.z;
    const bool odd = row % 2 == 1;
    const double x0 = -0.5 * length + (odd ? pitch : 0.5 * pitch);
    const unsigned whole = odd ? spec.columns - 1 : spec.columns;
    const double end = 0.5 * (length - spec.gap_m) - 0.5 * half_brick.x;  // centre of a half brick at the wall's end
    if (odd) bodies.push_back(box(half_brick, half_mass, spec.friction, {-end, 0, z}));
    for (unsigned i = 0; i < whole; ++i)
      bodies.push_back(box(spec.brick_m, spec.mass_kg, spec.friction, {x0 + i * pitch, 0, z}));
    if (odd) bodies.push_back(box(half_brick, half_mass, spec.friction, {end, 0, z}));
  }
  return bodies;
}

unsigned count_of(const PileSpec& spec) noexcept { return spec.count + 4; }

Bodies make_pile(const PileSpec& spec) {
  Bodies bodies;
  bodies.reserve(count_of(spec));
  const auto [columns, rows, pitch, shift] = layout_of(spec);
  // Inner size of the box: the layers with their shift, and one gap to the walls.
  const double inner_x = columns * pitch + shift, inner_y = rows * pitch + shift;
  const double t = spec.wall_thickness_m, h = spec.wall_height_m;
  for (const double side : {-1.0, 1.0})
    bodies.push_back(physics::make_fixed_body(kNoBody, Shape::box({0.5 * t, 0.5 * inner_y + t, 0.5 * h}), spec.friction,
                                              Posed{{side * 0.5 * (inner_x + t), 0, 0.5 * h}, {}}));
  for (const double side : {-1.0, 1.0})
    bodies.push_back(physics::make_fixed_body(kNoBody, Shape::box({0.5 * inner_x, 0.5 * t, 0.5 * h}), spec.friction,
                                              Posed{{0, side * 0.5 * (inner_y + t), 0.5 * h}, {}}));
  // A cube rotated by a small angle is wider by the factor cos + sin <= 1 + angle. Half of the gap is for that, a
  // quarter on each side for the offset, so that no two cubes can overlap.
  const double max_yaw = 0.5 * spec.gap_fraction, max_offset = 0.25 * spec.gap_fraction * spec.cube_m;
  Random random(spec.seed);
  const unsigned per_layer = columns * rows;
  for (unsigned n = 0; n < spec.count; ++n) {
    const unsigned layer = n / per_layer, i = n % per_layer % columns, j = n % per_layer / columns;
    // The layers are shifted to the corners of a square, to the next corner after every two layers: each shift is along
    // one axis, x and y in turn.
    const unsigned corner = layer / 2 % 4;
    const double sx = corner == 1 || corner == 2 ? 0.5 : -0.5, sy = corner >= 2 ? 0.5 : -0.5;
    const double x = (i + 0.5) * pitch - 0.5 * columns * pitch + sx * shift + max_offset * random.symmetric();
    const double y = (j + 0.5) * pitch - 0.5 * rows * pitch + sy * shift + max_offset * random.symmetric();
    bodies.push_back(box({spec.cube_m, spec.cube_m, spec.cube_m}, spec.mass_kg, spec.friction,
                         {x, y, (layer + 0.5) * spec.cube_m}, about_z(max_yaw * random.symmetric())));
  }
  return bodies;
}

unsigned count_of(const TowerSpec& spec) noexcept { return spec.layers * spec.blocks_per_layer; }

Bodies make_tower(const TowerSpec& spec) {
  Bodies bodies;
  bodies.reserve(count_of(spec));
  for (unsigned layer = 0; layer < spec.layers; ++layer) {
    const double z = (layer + 0.5) * spec.block_m.z;
    const bool turned = layer % 2 == 1 && spec.blocks_per_layer > 1;
    for (unsigned i = 0; i < spec.blocks_per_layer; ++i) {
      const double aside = (i + 0.5 - 0.5 * spec.blocks_per_layer) * spec.block_m.y;
      // A rotated block is a block with its edges exchanged: this is exact, a rotation by a quarter turn would round.
      const Vec3d size = turned ? Vec3d{spec.block_m.y, spec.block_m.x, spec.block_m.z} : spec.block_m;
      bodies.push_back(box(size, spec.mass_kg, spec.friction, turned ? Vec3d{aside, 0, z} : Vec3d{0, aside, z}));
    }
  }
  return bodies;
}

unsigned count_of(const CardHouseSpec& spec) noexcept { return spec.levels * (3 * spec.levels + 1) / 2; }

Bodies make_card_house(const CardHouseSpec& spec) {
  Bodies bodies;
  bodies.reserve(count_of(spec));
  const auto [s, c] = sin_cos(spec.angle_rad);
  const double leg = spec.card_m.y, flat = spec.card_m.x, t = spec.card_m.z;
  // A leaning card in the x-z plane: its lowest corner is on the ground, and its upper corner touches the partner's in
  // the plane of symmetry.
  const double centre_x = 0.5 * (leg * s + t * c), centre_z = 0.5 * (leg * c + t * s);
  const double pair_pitch = flat + spec.gap_m, level_height = 2 * centre_z + t;
  const Vec3d leaning_size{t, flat, leg}, flat_size{flat, leg, t};
  const Quatd to_right = quat_from_rotation_vector(Vec3d{0, spec.angle_rad, 0});
  for (unsigned level = 0; level < spec.levels; ++level) {
    const unsigned pairs = spec.levels - level;
    const double ground = level * level_height, x0 = -0.5 * (pairs - 1) * pair_pitch;
    for (unsigned i = 0; i < pairs; ++i) {
      const double x = x0 + i * pair_pitch;
      bodies.push_back(box(leaning_size, spec.mass_kg, spec.friction, {x - centre_x, 0, ground + centre_z}, to_right));
      bodies.push_back(
          box(leaning_size, spec.mass_kg, spec.friction, {x + centre_x, 0, ground + centre_z}, conjugate(to_right)));
    }
    for (unsigned i = 0; i + 1 < pairs; ++i)
      bodies.push_back(box(flat_size, spec.mass_kg, spec.friction,
                           {x0 + (i + 0.5) * pair_pitch, 0, ground + 2 * centre_z + 0.5 * t}));
  }
  return bodies;
}

CardHouseNeeds needs_of(const CardHouseSpec& spec) {
  const auto [s, c] = sin_cos(spec.angle_rad);
  const double leg = spec.card_m.y, t = spec.card_m.z, aside = leg * s - t * c;
  CardHouseNeeds needs;
  if (spec.levels > 1) needs.top_friction = aside / (leg * c + t * s);
  // Loads in weights of one card. A flat card transmits half of its load and of its weight to the card below each end;
  // a leaning card transmits its load and weight to its foot. `loads[level][i]`: load of leaning card i, two for each
  // pair, left to right. The flat card i rests on cards 2 i + 1 and 2 i + 2.
  std::vector<std::vector<double>> loads(spec.levels);
  for (unsigned level = spec.levels; level-- > 0;) {
    const unsigned pairs = spec.levels - level;
    loads[level].assign(2 * pairs, 0.0);
    for (unsigned i = 0; i + 1 < pairs; ++i) {
      const double feet = 2 + loads[level + 1][2 * i] + loads[level + 1][2 * i + 1];  // of the pair above
      loads[level][2 * i + 1] += 0.5 * (1 + feet);
      loads[level][2 * i + 2] += 0.5 * (1 + feet);
    }
  }
  for (const auto& level : loads) {
    const double p = *std::max_element(level.begin(), level.end());
    needs.foot_friction.push_back((0.5 + p) / (1 + p) * aside / (leg * c));
  }
  return needs;
}

unsigned count_of(const DominoRowSpec& spec) noexcept { return spec.count; }

Bodies make_domino_row(const DominoRowSpec& spec) {
  Bodies bodies;
  bodies.reserve(spec.count);
  for (unsigned i = 0; i < spec.count; ++i)
    bodies.push_back(box(spec.domino_m, spec.mass_kg, spec.friction,
                         {(i - 0.5 * (spec.count - 1)) * spec.spacing_m, 0, 0.5 * spec.domino_m.z}));
  return bodies;
}

}  // namespace tactus::sim
