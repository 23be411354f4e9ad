// Finds the cause of a late tick, from the times measured by its thread and from the machine's activity on its core.
//
// First the classes of rt/loop/run_stats.h: own work, if the counts of the tick predict it; a late wake-up; or an
// interruption. Then the kind of interruption: the kernel counts page faults and context switches per thread, and
// interrupts per core. If none was counted although time passed, the cause is below the kernel (host, firmware, the
// other hardware thread of the core). This is inferred, not observed, so the evidence is always given. If the kernel's
// osnoise events are read (os_noise.h), they state what used the core and for how long, and decide between the last
// three. Pure: the same figures give the same cause.
// Thread: [any].
#pragma once

#include <concepts>
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
  kComputing = 6,  // only of a tick in time: computing took longest; for an overrun this would be own work
};
inline constexpr std::uint32_t kCauses = 6;  // of overruns

// Nanoseconds in microseconds, the unit of all that people read.
template <std::integral Integer>
constexpr double us(Integer ns) noexcept {
  return static_cast<double>(ns) * 1e-3;
}

const char* name_of(Cause cause);  // for people
const char* key_of(Cause cause);   // for JSON

// Typical values of this run's ticks.
struct Typical {
  std::int64_t wake_ns{0}, execution_ns{0};  // medians
  std::int64_t bare_worst_ns{0};             // latest wake-up of the bare timer; 0: not measured
};

struct Attribution {
  Cause cause{Cause::kMachine};
  std::string evidence;  // one line: the figures from which the cause was determined
};

// Cause of a tick that is an overrun or among the latest. `change`: the machine's counters around it, if known.
Attribution attribute(const loop::TickTimes& tick, std::int64_t period_ns, const Typical& typical,
                      const std::optional<MachineChange>& change);

}  // namespace tactus::timing
