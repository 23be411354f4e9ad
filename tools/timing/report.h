// Prints a timing run as text and as JSON with units in the keys. Thread: normal. Pure.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "tools/timing/run_timing.h"
#include "tools/version/provenance.h"

namespace tactus::timing {

std::string to_text(const TimingResult& result);
nlohmann::ordered_json to_json(const TimingResult& result);
// The plot that --svg writes.
std::string to_svg(const TimingResult& result, const Provenance& made);

// p50 or p99 of the loop's wake-up latency divided by that of `other`; 0 if there is none.
double wake_ratio(const TimingResult& result, const Histogram& other, double percent);

}  // namespace tactus::timing
