// Computing time against accuracy: `tactus experiment accuracy-cost`.
//
// Every setting of solver, sub-world and border is measured on the windows of the coupling study (coupling_study.h),
// against a direct run with many more sub-steps and a second relax sweep, so the error includes those of the coupling
// and of the solver. The cost of a tick is the CPU time of one thread on the haptic side, and the instruction count if
// available. A setting is on the Pareto front if no other is at least as accurate and cheaper. Thread: one.
#pragma once

#include <string>
#include <vector>

#include "tools/experiment/coupling/coupling_cases.h"
#include "tools/experiment/coupling/setting_cost.h"
#include "tools/experiment/progress.h"

namespace tactus::experiment {

struct CostPoint {
  std::string scene;
  CostSetting setting;
  bool is_default{false}, on_front{false};
  double force_error{0};                                     // RMS(F - F_ref) / RMS(F_ref), over all windows
  std::vector<double> force_error_by_seed, tick_us_by_seed;  // same, and the median tick, for each hand
  double hold_vibration_N{0}, sync_step_N{0};
  double loss{0}, gain{0};  // of kinetic energy, as coupling_study.h
  double tick_us_p50{0}, tick_us_p99{0}, tick_us_max{0};
  double global_us_per_tick{0};  // median global step divided by the ratio
  double instructions{0};        // of a tick, mean; 0: not counted
};

// One factor changed by one step, all others at the default.
struct ChangeCost {
  std::string scene, factor, from, to;
  double error_before{0}, error_after{0}, tick_us_before{0}, tick_us_after{0};
  double global_us_before{0}, global_us_after{0};  // per tick
};

struct CostRequest {
  std::vector<CouplingCase> cases;
  unsigned seeds{3};
  bool quick{false};    // one factor at a time only, two windows a seed
  std::string program;  // path of this program, to count instructions; empty: not counted
};

struct CostReport {
  std::vector<CostPoint> points;
  std::vector<ChangeCost> changes;
  unsigned seeds{0}, timed_seeds{0};  // hands; those whose ticks were timed, the first ones
  double period_us{0}, budget_us{0};  // of a tick: the whole period, and the governor's budget for computing
};

// The settings measured on a scene, the default first.
std::vector<CostSetting> settings_for(const sim::Scene& scene, unsigned members, bool quick);

// Marks the Pareto-optimal points of each scene in error and median tick.
void mark_front(std::vector<CostPoint>& points);

// The sums of each setting on one scene with one hand, in the order of settings_for.
using HandSums = std::vector<SettingSums>;
Result<HandSums> measure_hand(const CouplingCase& one, unsigned seed, bool quick, const Progress& progress);

// `measured`: the sums of other processes, scene by scene, for each the hands from the second on; their times are left
// out. Empty: all hands are measured here.
Result<CostReport> run_accuracy_cost(const CostRequest& request, const std::vector<HandSums>& measured,
                                     const Progress& progress);

// Runs under valgrind: the sub-world of a case with one setting (index in settings_for), from rest until the hand
// presses, then some ticks; only these are counted.
Status run_counted(const CouplingCase& one, std::size_t setting, bool quick);

std::string cost_table(const CostReport& report);
std::string cost_json(const CostReport& report);
std::string cost_csv(const CostReport& report);  // units in the header

}  // namespace tactus::experiment
