// Chooses the work of a tick before it begins: sub-steps from counts and a cost model, and how many members the next
// cycle may have. Never looks at a clock: the same counts give the same choice, and the choice goes on the tape.
//
// Thread: plan(), member_budget() [rt]; calibration elsewhere [setup]. Units: ns unless named.
// Bound: sub-steps stay within [min_sub_steps, sub_steps]; when even the fewest do not fit, the member budget shrinks
// and the cut predicate of the loop is the backstop.
#pragma once

#include <algorithm>
#include <cstdint>

namespace tactus::loop {

// Nanoseconds per unit of work. The defaults are the fixed table of virtual time; `calibrate` scales them to a core.
struct CostModel {
  double fixed{8000};
  double per_body{150};             // bounds, poses, bookkeeping
  double per_pair{60};              // a pair that narrow phase looks at
  double per_contact{700};          // a manifold: collide, match, prepare
  double per_point_sub_step{95};    // warm start, biased and relax sweep of a contact point
  double per_body_sub_step{60};     // integration
  double per_border_sub_step{110};  // a border contact
  double synchronisation{15000};    // a tick that adopts a snapshot
  double per_join{1500};
};

// What is known of a tick before it begins: the counts of the one before, and the joins to come.
struct WorkCounts {
  std::uint32_t bodies{0}, pairs{0}, contacts{0}, points{0}, border{0};
  std::uint32_t joins{0};
  bool synchronises{false};
};

struct TickPlan {
  std::uint32_t sub_steps{4};
  std::uint32_t reduced{0};  // 1: fewer than asked for
  double predicted_ns{0};
};

// A joiner brings contacts that no count knows yet; a cube in a heap has about six neighbours of four points.
inline constexpr double kContactsPerJoin = 6, kPointsPerContact = 4;

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

  TickPlan plan(const WorkCounts& counts) const noexcept;

  // Once a cycle: how many members the next one may have, so that the fewest sub-steps fit. Falls at once, rises by
  // one a cycle and only with a fifth to spare.
  std::uint32_t member_budget(const WorkCounts& counts) noexcept;

  const GovernorConfig& config() const noexcept { return config_; }

 private:
  GovernorConfig config_;
  std::uint32_t member_budget_;
};

}  // namespace tactus::loop
