// Measures the cost table of this core: times ticks of synthetic sub-worlds of known work, in turns, and fits the
// costs.
//
// The ratios of the costs come from many consecutive ticks; their level comes from ticks after a sleep as long as the
// loop's own, during which other threads and the kernel use the core's caches: that costs a tick up to half of its
// time. Thread: [setup], on the core that the loop will run on, at its priority, while another thread loads the global
// world's core with work_beside: two cores may share caches, memory or even execution units, and a core measured alone
// is then nearly twice as fast as the one that the loop gets. Units: ns.
// Bound: some 0.4 s. The level of the table is clamped to 1/8 to 64 times that of the fixed table; beyond it the clock
// or the machine is not credible.
#pragma once

#include <atomic>

#include "rt/calibration/cost_fit.h"

namespace tactus::loop {

struct Calibration {
  CostModel cost;
  double scale{1};   // cost on this core / by the fixed table, for a sub-world of boxes in contact
  double spread{1};  // p90 / median of the times of its ticks after a sleep: unsteadiness of this core
};

// Medians over many rounds; the runs alternate, so that other load of the machine affects all of them equally.
CalibrationTimes time_synthetic_worlds();

// `safety`: factor on the measured p90, so that most ticks stay below their prediction.
Calibration calibrate(const CostModel& table, double safety = 1.25);

// Does the same kind of work until `stop` is set.
void work_beside(const std::atomic<bool>& stop);

}  // namespace tactus::loop
