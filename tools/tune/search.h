// The walk to the most accurate setting that fits: from the scene's own, one factor by one notch at a time.
//
// Each round tries every notch that may buy accuracy and takes the one with the least error among those that fit; where
// the start does not fit, the notches that cost the least accuracy are taken back first. At the end what buys nothing
// is taken back. Thread: one. Bound: sixteen rounds each way, of at most five trials.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "tools/experiment/coupling/setting_cost.h"

namespace tactus::tune {

using experiment::Setting;

// The ratios that are tried, ascending; beside the one that the scene asks for.
inline constexpr std::array kRatios{1u, 2u, 4u, 8u, 16u};

// What it has to fit into.
struct Limits {
  double tick_us{600};    // of the period: the governor's budget
  double global_us{800};  // a tick's share of a global step
  unsigned members{256}, sub_steps{16};
  unsigned bodies{256};  // that move: more members are none
};

// What a setting does and takes on this PC.
struct Trial {
  Setting setting;
  double force_error{0};                  // RMS(F - F_ref) / RMS(F_ref)
  double tick_us_p50{0}, tick_us_p99{0};  // of the haptic side, as the loop has them
  double global_us_per_tick{0};           // 9 of 10 global steps take less than ratio times this
  bool fits(const Limits& limits) const;
};

struct Notch {
  std::string factor, from, to;
  Setting setting;
};

// From `setting`, one factor at a time: towards accuracy, and back. Within the limits of members and sub-steps.
std::vector<Notch> notches_up(const Setting& setting, const Limits& limits);
std::vector<Notch> notches_down(const Setting& setting, const Limits& limits);
// Stiffer contacts, where the sub-steps resolve them; empty where they do not.
std::vector<Notch> notches_stiffer(const Setting& setting);

using Measure = std::function<Trial(const Setting&)>;

struct Found {
  Trial best;
  bool fits{false};  // else it is the cheapest that was tried, and nothing fits
};

// `measure` may be asked for a setting more than once: it remembers.
Found search(const Setting& start, const Limits& limits, const Measure& measure);

}  // namespace tactus::tune
