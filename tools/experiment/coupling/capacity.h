// Number of bodies that each coupling sustains, by rate and ratio: `tactus experiment capacity` (paper, section 3.1).
//
// A heap of cubes with a proxy that presses and stirs, every cube awake. Sustained: 99 of 100 ticks take less than the
// tick period, and 9 of 10 global steps less than their r ticks. Measured is CPU time, the minimum over a few identical
// runs, to reduce the effect of other load. The global world is computed on another core while the haptic side waits:
// as in a real-time run it does not displace what the haptic core's caches hold. The heap doubles until a limit is
// exceeded, then the number is narrowed down by bisection. Thread: one, which starts the other.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "rt/base/result.h"
#include "rt/haptics/coupling/coupling_scheme.h"
#include "tools/experiment/coupling/scheme.h"
#include "tools/experiment/progress.h"

namespace tactus::experiment {

struct CapacityRequest {
  std::vector<double> rates_Hz;
  std::vector<unsigned> ratios;
  std::vector<Scheme> couplings;  // each with every ratio; the direct coupling has none
  unsigned members{64};
  unsigned most_bodies{20000};
  unsigned ticks{400};  // timed, of each heap; at least 40 global steps
  // A heap that is too slow is run again, up to this number of runs. The runs are bit-identical, so the minimum time of
  // each step counts.
  unsigned runs{5};
};

// One heap, timed.
struct CapacityPoint {
  Scheme scheme{kDirectScheme};
  double rate_Hz{1000};
  unsigned bodies{0}, contact_points{0};  // points: of the whole world
  double tick_us_p50{0}, tick_us_p99{0};
  double step_us_p50{0}, step_us_p90{0};  // global; 0 with the direct coupling
  double tick_load{0}, step_load{0};      // p99 of the ticks and p90 of the global steps, each divided by its limit
  double load() const { return tick_load > step_load ? tick_load : step_load; }
  bool fits() const { return load() <= 1; }
};

struct CapacityRow {
  Scheme scheme{kDirectScheme};
  double rate_Hz{1000};
  unsigned bodies{0};    // sustained; 0: the smallest heap is not sustained
  unsigned too_many{0};  // the smallest heap that was not sustained; 0: none found
  std::string breaks;    // what exceeded its limit there: tick or global step
  double quotient{0};    // bodies relative to the direct coupling at the same rate; 0: not measured
};

struct CapacityReport {
  std::vector<CapacityRow> rows;
  std::vector<CapacityPoint> points;
  unsigned members{0}, runs{0};
  bool two_cores{false};  // the global world was computed on a core of its own
};

// Error, one line: a scene is refused.
Result<CapacityReport> run_capacity(const CapacityRequest& request, const Progress& progress);

// Largest number between `least` and `most` for which `fits` is true, by doubling, then bisected to a factor of
// 2^(1/8).
// Returns {largest that fits or 0, smallest tried that does not or 0}.
struct Bracket {
  unsigned fits{0}, too_many{0};
};
Bracket find_capacity(unsigned least, unsigned most, const std::function<bool(unsigned)>& fits);

std::string capacity_table(const CapacityReport& report);
std::string capacity_json(const CapacityReport& report);
std::string capacity_csv(const CapacityReport& report);  // units in the header

}  // namespace tactus::experiment
