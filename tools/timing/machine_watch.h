// Records the machine's activity on a core: interrupts by kind, time taken by a host, time that the haptic thread
// waited while ready. Sampled periodically from another core and kept, to explain latency spikes afterwards.
//
// Thread: normal. Changes nothing; figures that the kernel does not report stay empty. Units in the names.
// Bound: the last kKept samples. Source: proc(5): /proc/interrupts, /proc/stat, /proc/PID/task/TID/schedstat.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "tools/timing/os_noise.h"

namespace tactus::timing {

// Counts since boot, on one core.
struct InterruptCounts {
  std::uint64_t timer{0};    // the kernel's local timer
  std::uint64_t devices{0};  // numbered lines
  std::uint64_t kernel{0};   // between cores and of the CPU itself: rescheduling, calls, page tables, machine checks
};

// Counts of the core's column; empty if the text has none.
std::optional<InterruptCounts> parse_interrupts(const std::string& proc_interrupts, int cpu);
// Second value of "run wait slices" [ns]: time for which the thread was ready while another one ran.
std::optional<std::uint64_t> parse_wait_ns(const std::string& schedstat);

struct MachineLook {
  std::int64_t at_ns{0};
  std::optional<InterruptCounts> interrupts;
  std::optional<std::uint64_t> stolen_ms, waited_ns;
  std::optional<std::vector<Noise>> noise{};  // since the previous sample; empty if not measured
};

// Difference between two samples.
struct MachineChange {
  std::int64_t span_ns{0};
  std::optional<InterruptCounts> interrupts;
  std::optional<std::uint64_t> stolen_ms, waited_ns;
  std::optional<std::vector<Noise>> noise{};  // events that overlap the requested interval, clipped to it
};

class MachineHistory {
 public:
  void add(const MachineLook& look);
  std::int64_t last_ns() const { return looks_.empty() ? 0 : looks_.back().at_ns; }
  // Change from the last sample before `from` to the first after `to`; empty if one is missing.
  std::optional<MachineChange> around(std::int64_t from_ns, std::int64_t to_ns) const;

 private:
  static constexpr std::size_t kKept = 1000;
  std::deque<MachineLook> looks_;
};

// Samples this machine now. `thread_id`: of a thread of this process; 0: not known yet.
MachineLook look_at_machine(int cpu, int thread_id);

}  // namespace tactus::timing
