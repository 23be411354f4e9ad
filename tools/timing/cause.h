// Why a tick was late: from what its thread saw of itself, and from what the machine did to its core meanwhile.
//
// The first answer is that of rt/loop/run_stats.h: own work, where the counts of the tick foresee it; a late wake-up;
// or interrupted. What interrupted it is then told apart: a page fault and a context switch the kernel counts for the
// thread, an interrupt it counts for the core. Where none of them is counted and yet the clock ran on, it was the
// machine below the kernel (its host, its firmware, another thread of the core's hardware): inferred, never seen, and
// so always with what it is inferred from. Where the kernel's osnoise events are read (os_noise.h), they say what took
// the core and for how long, and decide between the last three. Pure: the same figures give the same cause. Thread:
// [any].
#pragma once

#include <optional>
#include <string>

#include "rt/loop/tick_probe.h"
#include "tools/timing/machine_watch.h"

namespace tactus::timing {

enum class Cause : std::uint32_t {
  kLateWake = 0,
  kPageFault = 1,
  kContextSwitch = 2,
  kInterrupt = 3,
  kOwnWork = 4,
  kMachine = 5,
  kComputing = 6,  // of a tick in time alone: computing is what took longest; an overrun's would be own work
};
inline constexpr std::uint32_t kCauses = 6;  // of overruns

const char* name_of(Cause cause);  // for people
const char* key_of(Cause cause);   // for JSON

// What a tick of this run is like.
struct Typical {
  std::int64_t wake_ns{0}, execution_ns{0};  // medians
  std::int64_t bare_worst_ns{0};             // latest wake-up of the bare timer; 0: not measured
};

struct Attribution {
  Cause cause{Cause::kMachine};
  std::string evidence;  // one line: the figures that the cause was told from
};

// Of a tick that is an overrun or among the latest. `change`: of the machine around it, where it is known.
Attribution attribute(const loop::TickTimes& tick, std::int64_t period_ns, const Typical& typical,
                      const std::optional<MachineChange>& change);

}  // namespace tactus::timing
