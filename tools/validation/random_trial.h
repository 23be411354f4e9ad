// A random world with a hand: compares the sub-world coupling with the direct coupling, for five seconds.
//
// The world of the seed first settles (direct coupling, four seconds), so that some bodies stand. Then a proxy
// approaches one of the bodies from above or from a side, presses, moves to and fro, leaves and returns, with the arm
// in the loop of each run. Both runs start from the same bodies: ghost border, ratio 8, a cap on members that leaves
// bodies outside. Thread: one. Virtual time: the same seed, the same bits. Units: SI.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "tools/experiment/coupling/whole_run.h"

namespace tactus::hard_cases {

// A world collapses if a body falls that stands in all three direct runs, or if the force exceeds all bounds. The
// second direct run starts with every body displaced by up to kApart_m in each coordinate; the third takes kFinerSteps
// times as many sub-steps. A body that falls in one of them is not counted: the direct run does not say where it ends.
// Definition of standing: experiment::StandingRule.
//
// Collapses in worlds that start with an overlap above kMostOverlap of the thinner body are counted, and counted
// separately too: a run of such a scene is bad by the rule `overlap` of tools/session/verdict.h with any coupling,
// because contacts may resolve it to the far side.
//
// Counted separately, not as a collapse: a run that gains more energy than the direct run by kMaxGain of the energy at
// play. That is the hand's work, plus the weight of each body times its extent, plus the direct run's largest kinetic
// energy.
struct CollapseRule {
  static constexpr double kApart_m = 1e-6;
  static constexpr unsigned kFinerSteps = experiment::WholeRunRequest::kFinerSteps;
  static constexpr double kMostOverlap = 0.5;
  static constexpr double kMaxGain = 0.1;
};

inline constexpr double kTrialSettles_s = 4, kTrial_s = 5;
inline constexpr unsigned kTrialRatio = 8;

struct RandomTrial {
  std::uint64_t seed{0};
  std::string scene;            // TOML, as `tactus run` and `tactus experiment energy-loss --scene` take it
  experiment::WholeRunRow row;  // with its bodies
  std::vector<physics::Body> fixed;
  double start_overlap{0};    // deepest overlap at the start / thickness of the thinner body
  std::vector<BodyId> fell;   // bodies that stand in all direct runs and not here
  std::vector<BodyId> still;  // of these: at rest at the start, and still there at the end of the direct run

  bool lost() const noexcept { return !row.stands && row.fallen == 0; }  // by its force
  bool still_falls() const noexcept { return !still.empty(); }
  bool collapses() const noexcept { return !fell.empty() || lost(); }
  bool collapses_overlapping() const noexcept { return collapses() && start_overlap > CollapseRule::kMostOverlap; }
  bool falls_by_chance() const noexcept { return !row.stands && !collapses(); }
  double gain() const noexcept;  // energy gain beyond the direct run's, as a share of the energy at play
  bool gains_energy() const noexcept { return !(gain() <= CollapseRule::kMaxGain); }
};

// Bodies that stand in the direct run of `row` and in the `other` direct runs, and not in the run of `row`. All rows
// must have kept their bodies.
std::vector<BodyId> fallen_beside_all(const experiment::WholeRunRow& row,
                                      std::span<const experiment::WholeRunRow> others);

// Sort order: first worlds in which a resting body falls, then other collapses, then the rest; within each by the
// largest displacement of a standing body, or by the energy gain.
bool worse(const RandomTrial& a, const RandomTrial& b) noexcept;

// Error, one line: a scene file cannot represent the settled world, because bodies rotate or move too fast.
Result<RandomTrial> try_random_world(std::uint64_t seed);

}  // namespace tactus::hard_cases
