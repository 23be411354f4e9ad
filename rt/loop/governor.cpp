#include "rt/loop/governor.h"

#include <algorithm>

namespace tactus::loop {

WorkCounts with_joiners(const WorkCounts& known) noexcept {
  WorkCounts counts = known;
  counts.bodies += known.joins;
  counts.pairs += kContactsPerJoin * known.joins;
  counts.contacts += kContactsPerJoin * known.joins;
  counts.points += kContactsPerJoin * kPointsPerContact * known.joins;
  counts.comparisons += kContactsPerJoin * known.joins;
  return counts;
}

WorkCounts with_all_compared(const WorkCounts& known) noexcept {
  WorkCounts counts = known;
  counts.comparisons = std::max(known.pairs, known.comparisons);
  return counts;
}

CostModel units_of(const WorkCounts& n, std::uint32_t sub_steps) noexcept {
  const double s = sub_steps;
  return {.fixed = 1,
          .per_body = 1.0 * n.bodies,
          .per_pair = 1.0 * n.pairs,
          .per_search = 1.0 * n.comparisons,
          .per_contact = 1.0 * n.contacts,
          .per_border = 1.0 * n.border,
          .per_body_sub_step = s * n.bodies,
          .per_contact_sub_step = s * n.contacts,
          .per_point_sub_step = s * n.points,
          .per_border_sub_step = s * n.border,
          .synchronisation = n.synchronises ? 1.0 : 0.0,
          .per_border_synchronised = n.synchronises ? 1.0 * n.border : 0.0,
          .per_join = 1.0 * n.joins};
}

double predict_ns(const CostModel& cost, const WorkCounts& counts, std::uint32_t sub_steps) noexcept {
  const CostModel units = units_of(counts, sub_steps);
  double sum_ns = 0;
  for (const auto term : kCosts) sum_ns += cost.*term * units.*term;
  return sum_ns;
}

TickPlan Governor::plan(const WorkCounts& known) noexcept {
  comparisons_ = std::max(known.comparisons, comparisons_ - (comparisons_ + 15) / 16);
  WorkCounts counts = known;
  counts.comparisons = known.pairs > 0 ? comparisons_ : 0;
  counts = with_joiners(counts);
  const double budget_ns = config_.budget * config_.period_ns;
  TickPlan plan;
  plan.sub_steps = config_.sub_steps;
  plan.predicted_ns = predict_ns(config_.cost, counts, plan.sub_steps);
  while (plan.predicted_ns > budget_ns && plan.sub_steps > config_.min_sub_steps) {
    --plan.sub_steps;
    plan.predicted_ns = predict_ns(config_.cost, counts, plan.sub_steps);
  }
  plan.reduced = plan.sub_steps < config_.sub_steps ? 1 : 0;
  return plan;
}

std::uint32_t Governor::member_budget(const WorkCounts& counts) noexcept {
  const double budget_ns = config_.budget * config_.period_ns;
  const double predicted_ns = predict_ns(config_.cost, with_all_compared(counts), config_.min_sub_steps);
  if (counts.bodies > 0 && predicted_ns > budget_ns) {
    // All cost but the fixed one is proportional to the members.
    const double room_ns = std::max(0.0, budget_ns - config_.cost.fixed);
    const auto fit = static_cast<std::uint32_t>(counts.bodies * room_ns / (predicted_ns - config_.cost.fixed));
    member_budget_ = std::clamp(fit, config_.min_members, member_budget_);
  } else if (predicted_ns < 0.8 * budget_ns && member_budget_ < config_.members) {
    ++member_budget_;
  }
  return member_budget_;
}

}  // namespace tactus::loop
