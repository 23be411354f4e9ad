// tactus experiment hard-cases --random N --sub-world: results of N random worlds, and the worst of them.
// Thread: one. Units in the names. Bound: keeps the figures of every world, and the bodies of the worst.
#pragma once

#include <string>
#include <vector>

#include "tools/experiment/progress.h"
#include "tools/validation/random_trial.h"

namespace tactus::hard_cases {

struct TrialReport {
  static constexpr std::size_t kWorst = 10;

  std::uint64_t first{0}, worlds{0};
  std::vector<std::uint64_t> left_out;        // seeds whose world no scene file can represent
  std::uint64_t with_border{0};               // worlds with more moving bodies than the cap of members
  std::uint64_t standing{0};                  // number of bodies that stand in the direct runs
  std::vector<RandomTrial> noted;             // trials with a fall or an energy gain; without bodies and scene, by seed
  std::vector<RandomTrial> worst;             // at most kWorst, worst first
  std::vector<experiment::WholeRunRow> rows;  // of all, without bodies

  void add(RandomTrial trial);
  std::size_t collapsed() const;
  std::size_t still_fallen() const;  // of these: a body at rest in the direct run falls
  std::size_t by_chance() const;
  std::size_t gain_energy() const;
};

TrialReport try_random_worlds(std::uint64_t first, std::uint64_t worlds, const experiment::Progress& progress);

std::string trial_text(const TrialReport& report);
// {"worlds", "collapsed", "noted": [{"seed", "outcome", ...}], "worst": [{"seed", ..., "bodies": [...]}]}.
std::string trial_json(const TrialReport& report);

}  // namespace tactus::hard_cases
