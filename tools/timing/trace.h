// The ticks around the worst spikes, and the last ones of the run, as a trace for Perfetto and chrome://tracing: one
// slice per tick, below it one per stage, and a mark with its cause on each spike.
//
// Thread: normal. Pure. Format: the JSON trace event format; times in us from the first tick shown.
#pragma once

#include <string>

#include "tools/timing/tick_statistics.h"

namespace tactus::timing {

std::string trace_json(const TickStatistics& statistics);

}  // namespace tactus::timing
