// Searches the most accurate setting within the limits: from the scene's own, one factor by one step at a time.
//
// Each round tries every step that may improve accuracy and takes the one with the least error among those within the
// limits. If the start is beyond the limits, steps are first undone, those that cost the least accuracy first. At the
// end, steps without benefit are undone. Thread: one. Bound: sixteen rounds each way, of at most five trials.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "tools/experiment/coupling/setting_cost.h"

namespace tactus::tune {

using experiment::CostSetting;

// The ratios that are tried, ascending; in addition to the scene's ratio.
inline constexpr std::array kRatios{1u, 2u, 4u, 8u, 16u};

// Limits of a setting.
struct Limits {
  double tick_us{600};    // us per tick: the governor's budget
  double global_us{800};  // us per tick: global step divided by the ratio
  unsigned members{256}, sub_steps{16};
  unsigned bodies{256};  // moving bodies; more members are not possible
};

// Error and computing time of a setting on this PC.
struct Trial {
  CostSetting setting;
  double force_error{0};                  // RMS(F - F_ref) / RMS(F_ref)
  double tick_us_p50{0}, tick_us_p99{0};  // of the haptic side, in the loop
  double global_us_per_tick{0};           // 9 of 10 global steps take less than ratio times this
  bool fits(const Limits& limits) const;
};

struct SettingStep {
  std::string factor, from, to;
  CostSetting setting;
};

// Steps from `setting`, one factor at a time: towards higher accuracy, and back. Within the limits of members and
// sub-steps.
std::vector<SettingStep> changes_up(const CostSetting& setting, const Limits& limits);
std::vector<SettingStep> changes_down(const CostSetting& setting, const Limits& limits);
// Steps to stiffer contacts, if the sub-steps resolve them; otherwise empty.
std::vector<SettingStep> changes_stiffer(const CostSetting& setting);

using Measure = std::function<Trial(const CostSetting&)>;

struct Found {
  Trial best;
  bool fits{false};  // false: no setting fits; this is the cheapest that was tried
};

// `measure` may be called more than once for a setting; it must cache its results.
Found search(const CostSetting& start, const Limits& limits, const Measure& measure);

}  // namespace tactus::tune
