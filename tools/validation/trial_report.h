// tactus experiment hard-cases --random N --sub-world: results of N random worlds, and the worst of them.
// Thread: one. Units in the names. Bound: keeps the figures of every world, and the bodies of the worst.
#pragma once

#include <string>
#include <vector>

#include "tools/experiment/coupling/study_fields.h"
#include "tools/validation/random_trial.h"

namespace tactus::hard_cases {

// The trials of some seeds, in order, and those left out.
struct Trials {
  std::vector<RandomTrial> trials;
  std::vector<std::uint64_t> left_out;
};
Trials try_seeds(std::uint64_t first, std::uint64_t worlds);

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
  void add(Trials trials);
  std::size_t collapsed() const;
  std::size_t still_fallen() const;  // of these: a body at rest in the direct run falls
  std::size_t overlapping() const;   // of these: the world starts with an overlap that no run may have
  std::size_t by_chance() const;
  std::size_t gain_energy() const;
};

// --- the members, for experiment/part_bytes.h
template <class Io>
void fields(Io& io, RandomTrial& trial) {
  auto& [seed, scene, row, fixed, start_overlap, fell, still] = trial;
  io(seed, scene, row, fixed, start_overlap, fell, still);
}
template <class Io>
void fields(Io& io, Trials& trials) {
  auto& [done, left_out] = trials;
  io(done, left_out);
}

std::string trial_text(const TrialReport& report);
// {"worlds", "collapsed", "noted": [{"seed", "outcome", ...}], "worst": [{"seed", ..., "bodies": [...]}]}.
std::string trial_json(const TrialReport& report);

}  // namespace tactus::hard_cases
