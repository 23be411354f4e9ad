// What accuracy costs in time: `tactus experiment accuracy-cost`.
//
// Every setting of solver, sub-world and border is measured on the same windows as the couplings are
// (coupling_study.h), against a direct run with many more sub-steps and a second relax sweep: its error is the
// coupling's and the solver's. What a tick costs is CPU time of one thread on the haptic side, and instructions where
// the machine counts them. A setting is on the front when no other is as accurate and cheaper. Thread: one.
#pragma once

#include <string>
#include <vector>

#include "tools/experiment/coupling/coupling_cases.h"
#include "tools/experiment/coupling/setting_cost.h"
#include "tools/experiment/progress.h"

namespace tactus::experiment {

struct CostPoint {
  std::string scene;
  Setting setting;
  bool is_default{false}, on_front{false};
  double force_error{0};                                     // RMS(F - F_ref) / RMS(F_ref), over all windows
  std::vector<double> force_error_by_seed, tick_us_by_seed;  // the same, and the median tick, of each hand alone
  double hold_vibration_N{0}, sync_step_N{0};
  double loss{0}, gain{0};  // of kinetic energy, as coupling_study.h
  double tick_us_p50{0}, tick_us_p99{0}, tick_us_max{0};
  double global_us_per_tick{0};  // median global step / ratio
  double instructions{0};        // of a tick, mean; 0: not counted
};

// One factor changed by a notch, all others at the default.
struct Notch {
  std::string scene, factor, from, to;
  double error_before{0}, error_after{0}, tick_us_before{0}, tick_us_after{0};
  double global_us_before{0}, global_us_after{0};  // per tick
};

struct CostRequest {
  std::vector<CouplingCase> cases;
  unsigned seeds{3};
  bool quick{false};    // one factor at a time only, two windows a seed
  std::string program;  // this program's own path, for the count of instructions; empty: none are counted
};

struct CostReport {
  std::vector<CostPoint> points;
  std::vector<Notch> notches;
  unsigned seeds{0};
  double period_us{0}, budget_us{0};  // of a tick: all of it, and what the governor gives to computing
};

// The settings that are measured on a scene, the default first.
std::vector<Setting> settings_for(const sim::Scene& scene, unsigned members, bool quick);

// Marks the points that no other of their scene beats in both error and median tick.
void mark_front(std::vector<CostPoint>& points);

Result<CostReport> run_accuracy_cost(const CostRequest& request, const Progress& progress);

// What runs under valgrind: the sub-world of a case's setting (by its place in settings_for) from rest until the hand
// presses, then some ticks, which alone are counted.
Status run_counted(const CouplingCase& one, std::size_t setting, bool quick);

std::string cost_table(const CostReport& report);
std::string cost_json(const CostReport& report);
std::string cost_csv(const CostReport& report);  // units in the header

}  // namespace tactus::experiment
