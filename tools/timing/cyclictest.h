// Runs cyclictest (rt-tests) as a reference: same core, period and priority as the loop, alternating with it.
//
// Thread: normal. It is run as a program; its wake-up latencies are read one by one, in ns. Source: cyclictest(8), `-v
// -N`.
#pragma once

#include <string>

#include "rt/base/histogram.h"
#include "rt/base/result.h"

namespace tactus::timing {

struct CyclictestRun {
  int cpu{0}, main_cpu{-1};  // of its measuring thread; of the one that prints; -1: any
  int priority{80};
  double period_us{1000};
  unsigned seconds{9};
};

std::string cyclictest_command(const CyclictestRun& run);

// One line of its output, "thread: count: latency", into the histogram; other lines are ignored. The first `skip`
// wake-ups are not counted. False: the line was not a wake-up.
bool add_cyclictest_line(const std::string& line, std::uint64_t skip, Histogram& wake);

// Runs it to its end. Error, one line: it is not installed or fails.
Status run_cyclictest(const CyclictestRun& run, std::uint64_t skip, Histogram& wake);

}  // namespace tactus::timing
