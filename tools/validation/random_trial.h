// A random world with a hand: compares the sub-world coupling with the direct coupling, for five seconds.
//
// The world of the seed first settles (direct coupling, four seconds), so that some bodies stand. Then a proxy
// approaches one of the bodies from above or from a side, presses, moves to and fro, leaves and returns, with the arm
// in the loop of each run. Both runs start from the same bodies: ghost border, ratio 8, a cap on members that leaves
// bodies outside. Thread: one. Virtual time: the same seed, the same bits. Units: SI.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/experiment/coupling/whole_run.h"

namespace tactus::hard_cases {

// A world collapses if a body falls that stands both in the direct run and in a second direct run, in which every body
// starts displaced by up to kApart_m in each coordinate; or if the force exceeds all bounds. A body that also falls in
// one of the two direct runs is not counted, because its fall is not caused by the border. Definition of standing:
// experiment::StandingRule.
//
// Counted separately, not as a collapse: a run that gains more energy than the direct run by kMaxGain of the energy at
// play. That is the hand's work, plus the weight of each body times its extent, plus the direct run's largest kinetic
// energy.
struct CollapseRule {
  static constexpr double kApart_m = 1e-6;
  static constexpr double kMaxGain = 0.1;
};

inline constexpr double kTrialSettles_s = 4, kTrial_s = 5;
inline constexpr unsigned kTrialRatio = 8;

struct RandomTrial {
  std::uint64_t seed{0};
  std::string scene;            // TOML, as `tactus run` and `tactus experiment energy-loss --scene` take it
  experiment::WholeRunRow row;  // with its bodies
  std::vector<physics::Body> fixed;
  std::vector<BodyId> fell;   // bodies that stand in both direct runs and not here
  std::vector<BodyId> still;  // of these: at rest at the start, and still there at the end of the direct run

  bool lost() const noexcept { return !row.stands && row.fallen == 0; }  // by its force
  bool still_falls() const noexcept { return !still.empty(); }
  bool collapses() const noexcept { return !fell.empty() || lost(); }
  bool falls_by_chance() const noexcept { return !row.stands && !collapses(); }
  double gain() const noexcept;  // energy gain beyond the direct run's, as a share of the energy at play
  bool gains_energy() const noexcept { return !(gain() <= CollapseRule::kMaxGain); }
};

// Bodies that stand in the direct runs of both rows and not in the run of `row`. Both rows must have kept their bodies.
std::vector<BodyId> fallen_beside_both(const experiment::WholeRunRow& row, const experiment::WholeRunRow& apart);

// Sort order: first worlds in which a resting body falls, then other collapses, then the rest; within each by the
// largest displacement of a standing body, or by the energy gain.
bool worse(const RandomTrial& a, const RandomTrial& b) noexcept;

// Error, one line: a scene file cannot represent the settled world, because bodies rotate or move too fast.
Result<RandomTrial> try_random_world(std::uint64_t seed);

}  // namespace tactus::hard_cases
