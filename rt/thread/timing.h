// Timing of a periodic loop: the values that a tick receives, and the counters of the whole run.
//
// They do not affect the physics, which always uses the constant period. Thread: values; TimingHealth is written only
// by the loop's thread and read elsewhere as a copy, or after the thread has stopped.
// Units: ns of the loop's clock. Bound: fixed size; see rt/base/histogram.h for the range of the times.
#pragma once

#include <cstdint>
#include <type_traits>

#include "rt/base/histogram.h"

namespace tactus::loop {

struct TimingHealth {
  Histogram wake_latency;          // woken - scheduled
  Histogram execution;             // from woken to the end of the tick
  std::uint64_t ticks{0};          // executed
  std::uint64_t overruns{0};       // ticks that ended after the next deadline; counted once, however long
  std::uint64_t skipped_ticks{0};  // deadlines without a tick
  std::uint64_t late_wakes{0};     // wake latency above LoopSettings::late_wake_ns
  // Of the loop's thread between the first tick and the end. The real-time contract requires 0 page faults.
  std::uint64_t minor_faults{0}, major_faults{0};
  std::uint64_t involuntary_switches{0};  // preempted by another thread
};

struct TickTiming {
  std::uint64_t tick{0};                // number of ticks executed before this one
  std::uint64_t deadline{0};            // number of the deadline: first + deadline * period
  std::uint64_t skipped{0};             // deadlines skipped just before this one
  std::int64_t scheduled_ns{0};         // the deadline
  std::int64_t woke_ns{0};              // start of the tick
  std::int64_t last_execution_ns{0};    // of the tick before; 0 in the first
  const TimingHealth* health{nullptr};  // up to the tick before; not null in a tick
};

static_assert(std::is_trivially_copyable_v<TimingHealth>);

}  // namespace tactus::loop
