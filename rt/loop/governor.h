// Chooses the work of a tick before it starts: the number of sub-steps, from counts and a cost model, and the number of
// members allowed in the next cycle. Uses no clock: equal counts give an equal choice, and the choice is recorded on
// the tape.
//
// Thread: plan(), member_budget() [rt]; calibration elsewhere [setup]. Units: ns unless named.
// Bound: sub-steps stay within [min_sub_steps, sub_steps]. If even the minimum exceeds the budget, the member budget
// shrinks, and the loop's cut predicate limits the tick.
#pragma once

#include <algorithm>
#include <cstdint>
#include <iterator>

namespace tactus::loop {

// Nanoseconds per unit of work. The defaults are the fixed table for virtual time, measured by `calibrate` on an Intel
// Xeon (Sapphire Rapids) at 2 GHz, rounded, 2026-11-22. In real time `calibrate` measures the loop's own core.
struct CostModel {
  double fixed{15000};              // includes the cache misses after the loop's sleep
  double per_body{160};             // bounds, poses, counters
  double per_pair{50};              // a pair in the narrow phase
  double per_search{1000};          // a pair whose shapes are compared: two boxes; other shapes count as a fraction
  double per_contact{350};          // a manifold: update, prepare, store
  double per_border{200};           // a border contact: prepare, store
  double per_body_sub_step{30};     // integration
  double per_contact_sub_step{70};  // warm start, biased and relax sweep: per contact, then per point
  double per_point_sub_step{25};
  double per_border_sub_step{260};
  double synchronisation{3000};  // per tick that adopts a snapshot
  double per_border_synchronised{90};
  double per_join{100};
};

// All costs, for sums.
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

// Predicted work of a tick: the counts of the last tick and the joins of this one.
struct WorkCounts {
  std::uint32_t bodies{0}, pairs{0}, contacts{0}, points{0}, border{0};
  std::uint32_t comparisons{0};  // shape comparisons, in equivalent pairs of boxes: physics::StepReport::comparisons
  std::uint32_t joins{0};
  bool synchronises{false};
};

struct TickPlan {
  std::uint32_t sub_steps{4};
  std::uint32_t reduced{0};  // 1: fewer sub-steps than configured
  double predicted_ns{0};
};

// Estimated contacts of a joiner, which no count includes yet: a cube in a heap has about six neighbours of four
// points.
inline constexpr std::uint32_t kContactsPerJoin = 6, kPointsPerContact = 4;

// Cost of a joint in contacts: its rows per sweep and masses per sub-step take as long as those of two contacts.
inline constexpr std::uint32_t kContactsPerJoint = 2;

// The counts including the estimated bodies and contacts of the joiners.
WorkCounts with_joiners(const WorkCounts& counts) noexcept;
// Upper bound for these bodies and contacts: every pair is compared, none is carried over.
WorkCounts with_all_compared(const WorkCounts& counts) noexcept;

// Number of units of each cost in a tick of these counts.
CostModel units_of(const WorkCounts& counts, std::uint32_t sub_steps) noexcept;
double predict_ns(const CostModel& cost, const WorkCounts& counts, std::uint32_t sub_steps) noexcept;

struct GovernorConfig {
  double period_ns{1e6};
  double budget{0.6};  // share of the period for computing; the rest is for wake-up, the link and reserve
  std::uint32_t sub_steps{4}, min_sub_steps{1};
  std::uint32_t members{64}, min_members{8};
  CostModel cost;
};

class Governor {
 public:
  explicit Governor(const GovernorConfig& config) noexcept : config_(config), member_budget_(config.members) {
    config_.min_members = std::min(config_.min_members, config_.members);
  }

  // Plans a tick from the last tick's counts and its joins. Comparisons come in bursts: the prediction uses their
  // recent maximum, decayed. A tick that has to compare all pairs at once may exceed the plan; then the cut limits it.
  TickPlan plan(const WorkCounts& known) noexcept;

  // Call once a cycle. Members allowed in the next cycle, so that the minimum of sub-steps fits even if no contact is
  // carried over. Falls at once; rises by one per cycle, only while a fifth of the budget is free.
  std::uint32_t member_budget(const WorkCounts& counts) noexcept;

  const GovernorConfig& config() const noexcept { return config_; }

 private:
  GovernorConfig config_;
  std::uint32_t member_budget_;
  std::uint32_t comparisons_{0};  // recent maximum; decays by a sixteenth per tick
};

}  // namespace tactus::loop
