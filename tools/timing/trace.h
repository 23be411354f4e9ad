// The ticks around the worst spikes, and the last ones of the run, as a trace that Perfetto and chrome://tracing open:
// one slice a tick, one below it a stage, a mark on each spike with its cause.
//
// Thread: normal. Pure. Format: the JSON trace event format; times in us from the first tick shown.
#pragma once

#include <string>

#include "tools/timing/tick_statistics.h"

namespace tactus::timing {

std::string trace_json(const TickStatistics& books);

}  // namespace tactus::timing
