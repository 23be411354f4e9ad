// The usual worlds, made from a few numbers: wall, pile, tower, card house, row of dominoes.
//
// Pure functions: the same numbers give the same bodies, bit for bit, on every machine (own trigonometry, own random
// numbers). Bodies come without ids, at rest, in an order that is part of the contract: from the ground up.
// Frame: the part's own, origin on the ground in the middle of the part, z up; the loader places it. Units: SI.
// Bodies start in contact, with no overlap beyond rounding. Thread: [setup].
// Bound: what they are given must be in the ranges that the scene loader accepts; counts are the caller's to limit.
#pragma once

#include <cstdint>
#include <vector>

#include "rt/physics/body.h"

namespace tactus::sim {

using Bodies = std::vector<physics::Body>;

// Bricks in running bond: every other course begins with half a brick, and each brick rests on two.
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
// the one below, along x and y in turn, so that its cubes rest on two each and the whole heap hangs together by its
// contacts; cubes of the layers between stand on one. Yaw and place are jittered within the gaps.
struct PileSpec {
  unsigned count{700}, layers{8};
  double cube_m{0.05}, mass_kg{0.075}, friction{0};
  double gap_fraction{0.04};  // between neighbours of a layer, of the cube's edge
  double wall_height_m{0.5}, wall_thickness_m{0.05};
  std::uint64_t seed{1};
};
unsigned count_of(const PileSpec& spec) noexcept;  // the walls included: they come first
Bodies make_pile(const PileSpec& spec);

// Blocks on blocks. One block per layer: a stack. More: side by side, every other layer turned by a quarter turn.
struct TowerSpec {
  unsigned layers{18}, blocks_per_layer{3};
  Vec3d block_m{0.075, 0.025, 0.015};
  double mass_kg{0.02}, friction{0};
};
unsigned count_of(const TowerSpec& spec) noexcept;
Bodies make_tower(const TowerSpec& spec);

// Pairs of cards that lean on each other, each with the next joined by a flat card on which the level above stands.
// Level k of L has L - k pairs and L - k - 1 flat cards. Cards stand on their short edge and lie across, so that a flat
// card reaches from one pair's top to the next.
struct CardHouseSpec {
  unsigned levels{3};
  Vec3d card_m{0.0635, 0.0889, 0.002};   // short edge, long edge, thickness
  double angle_rad{0.2792526803190927};  // of a leaning card from the vertical
  double gap_m{0.0005};                  // between flat cards of a level
  double mass_kg{0.0135}, friction{0};
};
unsigned count_of(const CardHouseSpec& spec) noexcept;
Bodies make_card_house(const CardHouseSpec& spec);

// What a card house needs to stand, by level from the ground.
struct CardHouseNeeds {
  // Under the feet: a card of weight m g that carries P stands while mu > ((m g / 2 + P) / (m g + P)) a / (L cos), by
  // the balance of torques about its foot, of the most loaded card of the level. a = L sin - t cos is how far beside
  // the foot the corner is that carries, L the card's length, t its thickness.
  std::vector<double> foot_friction;
  // Where a flat card lies on the outermost pairs it is what keeps the one card that it loads from falling outwards, by
  // the friction on that card's top: mu > a / (L cos + t sin). What friction between the tops of the pair may add is
  // not counted: 3 % with five levels. 0 for one level, whose pair holds itself.
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
