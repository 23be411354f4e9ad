// tactus experiment scaling: cost of a step against bodies, contacts, sub-steps and the range of sizes.
//
// Each row is one world of tactus, settled, then timed. Instructions are counted if valgrind is installed (and was at
// build time): it runs this program again, once per row, and counts only the steps. Thread: one, on one core; in the
// sweep of threads each on its own core. Units in the names.
#pragma once

#include <string>
#include <vector>

#include "tools/experiment/engine.h"
#include "tools/experiment/progress.h"

namespace tactus::experiment {

struct ScalingCase {
  std::string sweep;  // sweep that the row belongs to: bodies, sub-steps, sizes, threads, stirred
  BoxPileSpec pile;
  unsigned sub_steps{4};
  double settle_s{2};
  std::uint32_t timed_steps{100};
  std::uint32_t threads{0};  // threads that share the step, timed by the wall clock; 0: one, timed by its CPU time
};

// The worlds of the experiment; `quick` leaves out those above 1000 cubes. `cores`: at most as many threads share a
// step.
std::vector<ScalingCase> scaling_cases(bool quick, std::size_t cores);

struct ScalingRow {
  std::string sweep;
  std::uint32_t bodies{0};
  unsigned sub_steps{0};
  std::uint32_t threads{1};
  double size_ratio{1};  // largest edge to smallest
  double contact_points{0}, touching_pairs{0};
  double median_us{0}, p99_us{0}, ns_per_point{0};
  double broad_phase_us{0};  // median time of the broad phase
  double instructions{0};    // per step; 0: not counted
  std::string failure;       // why the row is invalid; empty: valid
};

struct ScalingReport {
  std::vector<ScalingRow> rows;
  double exponent{0};              // of cost against contact points, over the sweep of bodies
  double instruction_exponent{0};  // the same of instructions; 0: not counted
};

// `program`: path of this program, to count instructions; empty: not counted. `quick`: the cases are those of
// scaling_cases(quick), so that the counted program finds the same ones.
ScalingReport run_scaling(const std::vector<ScalingCase>& cases, const EngineOptions& options,
                          const std::string& program, bool quick, const Progress& progress);

// Runs under valgrind: the case settles, then makes a few steps; only these are counted.
void run_counted(const ScalingCase& one, const EngineOptions& options);

std::string scaling_table(const ScalingReport& report);
std::string scaling_json(const ScalingReport& report);
std::string scaling_csv(const ScalingReport& report);  // units in the header
std::string scaling_svg(const ScalingReport& report);  // cost against contact points, both logarithmic

}  // namespace tactus::experiment
