// Measures the cost table of this core: ticks of synthetic sub-worlds whose work is known, in turns, and the costs that
// explain their times.
//
// What the costs are to one another comes from many ticks in a row; how high they are, from ticks after a sleep as long
// as the loop's own: until then other threads and the kernel have had the core's caches, which costs a tick up to half
// of its time. Thread: [setup], on the core that the loop will run on, at its priority, while another thread keeps the
// global world's core busy with work_beside: two cores may share caches, memory or even their execution units, and a
// core that was measured alone is then nearly twice as fast as the one that the loop gets. Units: ns.
// Bound: some 0.4 s. The table as a whole is held within 1/8 and 64 of the fixed one; beyond it the clock or the
// machine is not to be believed.
#pragma once

#include <atomic>

#include "rt/calibration/cost_fit.h"

namespace tactus::loop {

struct Calibration {
  CostModel cost;
  double scale{1};   // this core / the fixed table, of a sub-world of boxes in contact
  double spread{1};  // p90 of the times of its ticks after a sleep / their median: how steady this core is
};

// The medians of many rounds: every run has the same share of what else this machine does.
CalibrationTimes time_synthetic_worlds();

// `safety`: over the p90 that was measured, so that most ticks stay below their prediction.
Calibration calibrate(const CostModel& table, double safety = 1.25);

// The same kind of work until `stop` is set.
void work_beside(const std::atomic<bool>& stop);

}  // namespace tactus::loop
