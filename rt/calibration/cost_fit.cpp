#include "rt/calibration/cost_fit.h"

#include <optional>

namespace tactus::loop {
namespace {

using Run = CalibrationRun;

// The run that determines a cost; with `less`, the difference of the two runs.
struct Rule {
  double CostModel::*cost;
  Run run;
  std::optional<Run> less{};
};

constexpr Rule kRules[] = {
    {&CostModel::fixed, Run::kLone},
    {&CostModel::per_body_sub_step, Run::kFreeMore, Run::kFree},
    {&CostModel::per_body, Run::kFree, Run::kLone},
    {&CostModel::per_pair, Run::kApart, Run::kFree},
    {&CostModel::per_contact_sub_step, Run::kBallsMore, Run::kBalls},
    {&CostModel::per_point_sub_step, Run::kCarriedMore, Run::kCarried},
    {&CostModel::per_contact, Run::kCarried, Run::kFree},
    {&CostModel::per_search, Run::kSearched, Run::kCarried},
    {&CostModel::per_border_sub_step, Run::kBorderedMore, Run::kBordered},
    {&CostModel::per_border, Run::kBordered, Run::kFree},
    {&CostModel::synchronisation, Run::kSynchronising, Run::kFree},
    {&CostModel::per_border_synchronised, Run::kBorderedSynchronising, Run::kBordered},
    {&CostModel::per_join, Run::kJoining, Run::kSynchronising},
};
static_assert(std::size(kRules) == std::size(kCosts), "a cost is settled by no run, or by two");

// Each round reduces the error to less than a third (contacts and their points, the most strongly coupled costs), so
// that it is negligible after 40.
constexpr int kRounds = 40;

}  // namespace

CostModel fit_costs(const CalibrationTimes& times) noexcept {
  CostModel cost;
  for (const auto term : kCosts) cost.*term = 0;
  const auto at = [&](Run run) -> const TimedWork& { return times[static_cast<std::uint32_t>(run)]; };
  for (int round = 0; round < kRounds; ++round) {
    for (const Rule& rule : kRules) {
      const auto unexplained_ns = [&](const TimedWork& w) { return w.ns - predict_ns(cost, w.counts, w.sub_steps); };
      const auto units = [&](const TimedWork& w) { return units_of(w.counts, w.sub_steps).*rule.cost; };
      double ns = unexplained_ns(at(rule.run)), count = units(at(rule.run));
      if (rule.less) {
        ns -= unexplained_ns(at(*rule.less));
        count -= units(at(*rule.less));
      }
      if (count > 0) cost.*rule.cost = std::max(0.0, cost.*rule.cost + ns / count);
    }
  }
  return cost;
}

}  // namespace tactus::loop
