// Measures overlaps of bodies in the same way for every engine: from the poses that it reports, with tactus' collision
// functions, not from the engine's own contacts.
//
// Covers overlaps of bodies with each other, with the walls and with the stirrer's rods. Overlaps of rods with the
// floor are intended and not counted. Frame: that of the scene. Units: m; a share is of the thinner body's thickness
// (rt/physics/overlap.h). Thread: one. Bound: the pairs of boxes that overlap, at most kMaxPairs a body; pairs beyond
// make `complete` false.
#pragma once

#include <span>
#include <vector>

#include "rt/physics/world.h"
#include "sim/broad_phase/pair_grid.h"
#include "tools/experiment/scene.h"

namespace tactus::experiment {

struct Overlaps {
  double deepest_m{0}, deepest_share{0};
  double mean_m{0}, mean_share{0};  // mean over the bodies of each one's deepest overlap (0 if none)
  bool complete{true};              // false: a pose is not finite, or there were too many pairs
};

class OverlapJudge {
 public:
  explicit OverlapJudge(const BoxScene& scene);
  // `bodies`, `rods`: in the scene's order.
  Overlaps judge(std::span<const Posed> bodies, std::span<const Posed> rods);

 private:
  void judge_terrain(std::uint32_t a);
  void judge_pair(std::uint32_t a, const physics::Shape& shape_b, const Posed& pose_b, std::uint32_t b);

  static constexpr std::uint32_t kMaxPairs = 64;
  static constexpr std::uint32_t kNoBody = 0xffffffffu;

  std::vector<physics::Shape> shapes_;  // of the bodies, then of the rods
  std::vector<physics::Hull> hulls_;
  std::optional<sim::BuiltMesh> terrain_;
  std::uint32_t bodies_;
  std::vector<physics::Shape> wall_shapes_;
  std::vector<Posed> wall_poses_;
  sim::PairGrid grid_;
  BoundedVector<physics::SlotPair> pairs_;
  std::vector<Posed> poses_;             // as the shapes
  std::vector<physics::Aabb> bounds_;    // as the shapes
  std::vector<double> depth_m_, share_;  // by body: its deepest
};

}  // namespace tactus::experiment
