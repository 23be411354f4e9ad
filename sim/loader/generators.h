// Generators of common test worlds from a few numbers: wall, pile, tower, card house, row of dominoes.
//
// Pure functions: the same numbers give the same bodies, bit for bit, on every machine (own trigonometry, own random
// numbers). Bodies have no ids, are at rest, and are ordered from the ground up; the order is part of the contract.
// Frame: the part's own, origin on the ground in the middle of the part, z up; the loader places it. Units: SI. Bodies
// start in contact, with no overlap beyond rounding.
// Thread: [setup]. Bound: arguments must be in the ranges that the scene loader accepts; the caller limits the counts.
#pragma once

#include <cstdint>
#include <vector>

#include "rt/physics/body.h"

namespace tactus::sim {

using Bodies = std::vector<physics::Body>;

// Bricks in running bond: every other course starts with half a brick, and each brick rests on two.
struct WallSpec {
  unsigned columns{6}, rows{6};
  Vec3d brick_m{0.1, 0.05, 0.05};  // along the wall (x), through it (y), up (z)
  double gap_m{0};                 // between bricks of a course
  double mass_kg{0.2};             // of a whole brick; half bricks weigh half
  double friction{0};
};
unsigned count_of(const WallSpec& spec) noexcept;
Bodies make_wall(const WallSpec& spec);

// Cubes in layers inside an open box of four fixed walls. Every second layer is shifted by a quarter of a cube against
// the one below, along x and y in turn, so that each of its cubes rests on two and contacts connect the whole heap;
// cubes of the other layers stand on one. Yaw and position are random within the gaps.
struct PileSpec {
  unsigned count{700}, layers{8};
  double cube_m{0.05}, mass_kg{0.075}, friction{0};
  double gap_fraction{0.04};  // between neighbours of a layer, of the cube's edge
  double wall_height_m{0.5}, wall_thickness_m{0.05};
  std::uint64_t seed{1};
};
unsigned count_of(const PileSpec& spec) noexcept;  // includes the walls, which come first
Bodies make_pile(const PileSpec& spec);

// Layers of blocks. One block per layer: a stack. More: side by side, every other layer rotated by a quarter turn.
struct TowerSpec {
  unsigned layers{18}, blocks_per_layer{3};
  Vec3d block_m{0.075, 0.025, 0.015};
  double mass_kg{0.02}, friction{0};
};
unsigned count_of(const TowerSpec& spec) noexcept;
Bodies make_tower(const TowerSpec& spec);

// Pairs of cards that lean on each other; a flat card connects each pair's top with the next, and the level above
// stands on the flat cards. Level k of L has L - k pairs and L - k - 1 flat cards. Leaning cards stand on their short
// edge; flat cards lie across, so that they reach from one pair's top to the next.
struct CardHouseSpec {
  unsigned levels{3};
  Vec3d card_m{0.0635, 0.0889, 0.002};   // short edge, long edge, thickness
  double angle_rad{0.2792526803190927};  // of a leaning card from the vertical
  double gap_m{0.0005};                  // between flat cards of a level
  double mass_kg{0.0135}, friction{0};
};
unsigned count_of(const CardHouseSpec& spec) noexcept;
Bodies make_card_house(const CardHouseSpec& spec);

// Minimum friction coefficients with which a card house stands.
struct CardHouseNeeds {
  // Under the feet, by level from the ground, for the most loaded card of the level. A card of weight m g that carries
  // a load P stands if mu > ((m g / 2 + P) / (m g + P)) a / (L cos), by the balance of torques about its foot. a = L
  // sin - t cos: horizontal distance from the foot to the loaded corner; L: the card's length; t: its thickness.
  std::vector<double> foot_friction;
  // On the top of an outermost pair: the flat card loads one card there, and only its friction keeps that card from
  // falling outwards: mu > a / (L cos + t sin). The friction between the tops of the pair is neglected: 3 % with five
  // levels. 0 for one level, where the pair supports itself.
  double top_friction{0};
};
CardHouseNeeds needs_of(const CardHouseSpec& spec);

// Upright slabs in a row along x, thickness along x.
struct DominoRowSpec {
  unsigned count{20};
  Vec3d domino_m{0.0075, 0.024, 0.048};
  double spacing_m{0.024};  // from centre to centre
  double mass_kg{0.01}, friction{0};
};
unsigned count_of(const DominoRowSpec& spec) noexcept;
Bodies make_domino_row(const DominoRowSpec& spec);

}  // namespace tactus::sim
