// Chooses the work of a tick before it begins: sub-steps from counts and a cost model, and how many members the next
// cycle may have. Never looks at a clock: the same counts give the same choice, and the choice goes on the tape.
//
// Thread: plan(), member_budget() [rt]; calibration elsewhere [setup]. Units: ns unless named.
// Bound: sub-steps stay within [min_sub_steps, sub_steps]; when even the fewest do not fit, the member budget shrinks
// and the cut predicate of the loop is the backstop.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>

namespace tactus::loop {

// Nanoseconds per unit of work. The defaults are the fixed table of virtual time; `calibrate` measures a core's own.
// They are what it found on an Intel Xeon (Sapphire Rapids) at 2 GHz, rounded, 2026-11-22.
struct CostModel {
  double fixed{15000};              // also what the caches lose while the loop sleeps
  double per_body{160};             // bounds, poses, bookkeeping
  double per_pair{50};              // a pair that narrow phase knows
  double per_search{1000};          // one whose shapes it compares: boxes; other shapes by their share of it
  double per_contact{350};          // a manifold: update, prepare, store
  double per_border{200};           // a border contact: prepare, store
  double per_body_sub_step{30};     // integration
  double per_contact_sub_step{70};  // warm start, biased and relax sweep: of the contact, of each of its points
  double per_point_sub_step{25};
  double per_border_sub_step{260};
  double synchronisation{3000};  // a tick that adopts a snapshot
  double per_border_synchronised{90};
  double per_join{100};
};

// All of them, for sums.
inline constexpr double CostModel::*kCosts[] = {
    &CostModel::fixed,
    &CostModel::per_body,
    &CostModel::per_pair,
    &CostModel::per_search,
    &CostModel::per_contact,
    &CostModel::per_border,
    &CostModel::per_body_sub_step,
    &CostModel::per_contact_sub_step,
    &CostModel::per_point_sub_step,
    &CostModel::per_border_sub_step,
    &CostModel::synchronisation,
    &CostModel::per_border_synchronised,
    &CostModel::per_join,
};
static_assert(sizeof(CostModel) == sizeof(double) * std::size(kCosts), "one is not listed");

// What is known of a tick before it begins: the counts of the one before, and the joins to come.
struct WorkCounts {
  std::uint32_t bodies{0}, pairs{0}, contacts{0}, points{0}, border{0};
  std::uint32_t searched{0};  // the work of comparing shapes, in pairs of boxes: physics::StepReport::comparisons
  std::uint32_t joins{0};
  bool synchronises{false};
};

struct TickPlan {
  std::uint32_t sub_steps{4};
  std::uint32_t reduced{0};  // 1: fewer than asked for
  double predicted_ns{0};
};

// A joiner brings contacts that no count knows yet; a cube in a heap has about six neighbours of four points.
inline constexpr std::uint32_t kContactsPerJoin = 6, kPointsPerContact = 4;

// A joint's rows in every sweep and its masses in every sub-step take as long as those of two contacts.
inline constexpr std::uint32_t kContactsPerJoint = 2;

// The counts with the joiners' bodies and contacts among them.
WorkCounts with_joiners(const WorkCounts& counts) noexcept;
// The most that these bodies and contacts may cost: nothing is carried over.
WorkCounts with_all_searched(const WorkCounts& counts) noexcept;

// How often a tick of these counts incurs each cost.
CostModel units_of(const WorkCounts& counts, std::uint32_t sub_steps) noexcept;
double predict_ns(const CostModel& cost, const WorkCounts& counts, std::uint32_t sub_steps) noexcept;

struct GovernorConfig {
  double period_ns{1e6};
  double budget{0.6};  // of the period, for computing; the rest is for wake-up, the link and the unexpected
  std::uint32_t sub_steps{4}, min_sub_steps{1};
  std::uint32_t members{64}, min_members{8};
  CostModel cost;
};

class Governor {
 public:
  explicit Governor(const GovernorConfig& config) noexcept : config_(config), member_budget_(config.members) {
    config_.min_members = std::min(config_.min_members, config_.members);
  }

  // Of the counts as they were, and the joins to come. Searches come in bursts: as many as lately are expected. Where
  // all pairs have to be searched at once, the cut is there.
  TickPlan plan(const WorkCounts& known) noexcept;

  // Once a cycle: how many members the next one may have, so that the fewest sub-steps fit even where nothing is
  // carried over. Falls at once, rises by one a cycle and only with a fifth to spare.
  std::uint32_t member_budget(const WorkCounts& counts) noexcept;

  const GovernorConfig& config() const noexcept { return config_; }

 private:
  GovernorConfig config_;
  std::uint32_t member_budget_;
  std::uint32_t searched_{0};  // lately: a sixteenth less in each tick
};

}  // namespace tactus::loop
