#include "tools/tune/search.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "sim/model/step_settings.h"

namespace tactus::tune {
namespace {

constexpr unsigned kMaxRounds = 16;
// A step is kept if it reduces the error to this share or less; a step is undone if that raises the error by at most
// the second factor.
constexpr double kWorth = 0.98, kForNothing = 1.005;

// `what`: a member of CostSetting, or a function that returns a reference to the part that changes.
template <class What, class T>
void add(std::vector<SettingStep>& changes, const char* factor, const CostSetting& from, What what, T to) {
  const T now = std::invoke(what, from);
  if (now == to) return;
  SettingStep change{.factor = factor, .from = fmt::format("{}", now), .to = fmt::format("{}", to), .setting = from};
  std::invoke(what, change.setting) = to;
  changes.push_back(change);
}

constexpr auto kRatioOf = [](auto& setting) -> auto& { return setting.scheme.ratio; };

bool cheaper(const Trial& a, const Trial& b) {
  return a.tick_us_p99 + a.global_us_per_tick < b.tick_us_p99 + b.global_us_per_tick;
}

}  // namespace

bool Trial::fits(const Limits& limits) const {
  return tick_us_p99 <= limits.tick_us && global_us_per_tick <= limits.global_us && setting.members <= limits.members &&
         setting.sub_steps <= limits.sub_steps;
}

std::vector<SettingStep> changes_up(const CostSetting& s, const Limits& limits) {
  std::vector<SettingStep> changes;
  if (2 * s.sub_steps <= limits.sub_steps) add(changes, "sub-steps", s, &CostSetting::sub_steps, 2 * s.sub_steps);
  if (s.relax_sweeps < 2) add(changes, "relax sweeps", s, &CostSetting::relax_sweeps, 2u);
  const unsigned most = std::min(limits.members, limits.bodies);
  if (s.members < most) add(changes, "members", s, &CostSetting::members, std::min(2 * s.members, most));
  if (2 * s.members < most) add(changes, "members", s, &CostSetting::members, most);
  const auto below = std::lower_bound(kRatios.begin(), kRatios.end(), s.scheme.ratio);
  if (below != kRatios.begin()) add(changes, "ratio", s, kRatioOf, *(below - 1));
  return changes;
}

std::vector<SettingStep> changes_down(const CostSetting& s, const Limits& limits) {
  std::vector<SettingStep> changes;
  const unsigned sub_steps = std::min(std::max(1u, s.sub_steps / 2), limits.sub_steps);
  if (sub_steps >= sim::least_sub_steps(s.contact_Hz, 1 / experiment::kHapticRate_Hz))
    add(changes, "sub-steps", s, &CostSetting::sub_steps, sub_steps);
  if (s.relax_sweeps > 1) add(changes, "relax sweeps", s, &CostSetting::relax_sweeps, 1u);
  add(changes, "members", s, &CostSetting::members,
      std::min({std::max(1u, s.members / 2), limits.members, limits.bodies}));
  const auto above = std::upper_bound(kRatios.begin(), kRatios.end(), s.scheme.ratio);
  if (above != kRatios.end()) add(changes, "ratio", s, kRatioOf, *above);
  return changes;
}

std::vector<SettingStep> changes_stiffer(const CostSetting& s) {
  std::vector<SettingStep> changes;
  if (s.sub_steps >= sim::least_sub_steps(2 * s.contact_Hz, 1 / experiment::kHapticRate_Hz))
    add(changes, "contact frequency [Hz]", s, &CostSetting::contact_Hz, 2 * s.contact_Hz);
  return changes;
}

Found search(const CostSetting& start, const Limits& limits, const Measure& measure) {
  Found found;
  found.best = measure(start);
  for (unsigned round = 0; round < kMaxRounds && !found.best.fits(limits); ++round) {
    std::vector<Trial> tried;
    for (const SettingStep& change : changes_down(found.best.setting, limits)) tried.push_back(measure(change.setting));
    std::erase_if(tried, [&](const Trial& t) { return !t.fits(limits) && !cheaper(t, found.best); });
    if (tried.empty()) return found;
    // Of the settings within the limits, or else of the cheaper ones, the most accurate.
    found.best = *std::min_element(tried.begin(), tried.end(), [&](const Trial& a, const Trial& b) {
      return a.fits(limits) != b.fits(limits) ? a.fits(limits) : a.force_error < b.force_error;
    });
  }
  found.fits = found.best.fits(limits);
  if (!found.fits) return found;
  for (unsigned round = 0; round < kMaxRounds; ++round) {
    Trial next = found.best;
    for (const SettingStep& change : changes_up(found.best.setting, limits)) {
      const Trial trial = measure(change.setting);
      const double worth = kWorth * found.best.force_error;
      if (trial.fits(limits) && trial.force_error < std::min(worth, next.force_error)) next = trial;
    }
    if (next.setting == found.best.setting) break;
    found.best = next;
  }
  const double error = found.best.force_error;
  for (const SettingStep& change : changes_down(found.best.setting, limits)) {
    if (change.factor == "ratio") continue;  // the ratio changes only the global world's time
    const Trial trial = measure(change.setting);
    if (trial.fits(limits) && trial.force_error <= kForNothing * error && cheaper(trial, found.best)) {
      found.best = trial;
      break;
    }
  }
  return found;
}

}  // namespace tactus::tune
