#include "rt/loop/governor.h"

#include <algorithm>

namespace tactus::loop {

double predict_ns(const CostModel& c, const WorkCounts& n, std::uint32_t sub_steps) noexcept {
  const double bodies = n.bodies + n.joins;
  const double contacts = n.contacts + kContactsPerJoin * n.joins;
  const double points = n.points + kContactsPerJoin * kPointsPerContact * n.joins;
  const double once = c.fixed + c.per_body * bodies + c.per_pair * (n.pairs + kContactsPerJoin * n.joins) +
                      c.per_contact * contacts + (n.synchronises ? c.synchronisation + c.per_join * n.joins : 0.0);
  return once +
         sub_steps * (c.per_point_sub_step * points + c.per_body_sub_step * bodies + c.per_border_sub_step * n.border);
}

TickPlan Governor::plan(const WorkCounts& counts) const noexcept {
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
  const double predicted_ns = predict_ns(config_.cost, counts, config_.min_sub_steps);
  if (counts.bodies > 0 && predicted_ns > budget_ns) {
    // All but the fixed cost goes with the members.
    const double room_ns = std::max(0.0, budget_ns - config_.cost.fixed);
    const auto fit = static_cast<std::uint32_t>(counts.bodies * room_ns / (predicted_ns - config_.cost.fixed));
    member_budget_ = std::clamp(fit, config_.min_members, member_budget_);
  } else if (predicted_ns < 0.8 * budget_ns && member_budget_ < config_.members) {
    ++member_budget_;
  }
  return member_budget_;
}

}  // namespace tactus::loop
