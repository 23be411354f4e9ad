// Scales the fixed cost table to this core: runs a synthetic sub-world of known work and compares.
//
// Thread: [setup], on the core that the loop will run on, at its priority, while another thread keeps the global
// world's core busy with work_beside: two cores may share caches, memory or even their execution units, and a core
// that was measured alone is then nearly twice as fast as the one that the loop gets. Takes about a fifth of a second.
// Bound: the scale is held within 1/8 and 64; beyond it the clock or the machine is not to be believed.
#pragma once

#include <atomic>

#include "rt/loop/governor.h"

namespace tactus::loop {

struct Calibration {
  CostModel cost;    // the table, scaled
  double scale{1};   // this core / the table
  double spread{1};  // p99 of the measured ticks / their median: how steady this core is
};

// `safety`: the scaled table's cost over the measured p90, so that most ticks stay below their prediction.
Calibration calibrate(const CostModel& table, double safety = 1.15);

// The same kind of work until `stop` is set.
void work_beside(const std::atomic<bool>& stop);

}  // namespace tactus::loop
