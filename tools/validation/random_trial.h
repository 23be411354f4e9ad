// A random world with a hand in it: the sub-world coupling beside the direct one, for five seconds.
//
// The world of the seed is left alone until most of it rests (direct, four seconds), so that there is something that
// stands. Then a proxy comes to one of its bodies from above or from a side, presses, is moved to and fro, leaves and
// comes back, with the arm in the loop of the run itself. Both runs start from the same bodies: ghost border, ratio 8,
// a cap on members that leaves bodies outside. Thread: one. Virtual time: the same seed, the same bits. Units: SI.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/experiment/coupling/whole_run.h"

namespace tactus::hard_cases {

// A world collapses where a body falls that stands in the direct run and in a second direct run, of which every body
// starts up to kApart_m aside in each coordinate; or where the force leaves all bounds. A body that falls only beside
// one of the two direct runs falls by chance: the world decides, and not its border. Standing:
// experiment::StandingRule.
//
// Told apart, and no collapse: a run that gains more energy than the direct run by kMostGain of what is at play, which
// is the hand's work, the weight of each body times its extent, and the direct run's largest kinetic energy.
struct CollapseRule {
  static constexpr double kApart_m = 1e-6;
  static constexpr double kMostGain = 0.1;
};

inline constexpr double kTrialSettles_s = 4, kTrial_s = 5;
inline constexpr unsigned kTrialRatio = 8;

struct RandomTrial {
  std::uint64_t seed{0};
  std::string scene;            // TOML, as `tactus run` and `tactus experiment energy-loss --scene` take it
  experiment::WholeRunRow row;  // with its bodies
  std::vector<physics::Body> fixed;
  std::vector<BodyId> fell;   // who stands in both direct runs and not here
  std::vector<BodyId> still;  // of these: who rests at the start, and ends there in the direct run

  bool lost() const noexcept { return !row.stands && row.fallen == 0; }  // by its force
  bool still_falls() const noexcept { return !still.empty(); }
  bool collapses() const noexcept { return !fell.empty() || lost(); }
  bool falls_by_chance() const noexcept { return !row.stands && !collapses(); }
  double gain() const noexcept;  // of energy over the direct run's, share of what is at play
  bool gains_energy() const noexcept { return !(gain() <= CollapseRule::kMostGain); }
};

// Who stands in the direct runs of both rows and not in the run of `row`. Both rows keep their bodies.
std::vector<BodyId> fallen_beside_both(const experiment::WholeRunRow& row, const experiment::WholeRunRow& apart);

// To sort: where what stood still falls before what collapses before the rest, and each by how far a body that stands
// is off, or the gain.
bool worse(const RandomTrial& a, const RandomTrial& b) noexcept;

// One line where a scene file cannot say what the world has become: bodies that turn or fly too fast for one.
Result<RandomTrial> try_random_world(std::uint64_t seed);

}  // namespace tactus::hard_cases
