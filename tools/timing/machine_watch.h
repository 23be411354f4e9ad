// What the machine did to a core meanwhile: its interrupts by kind, the time that a host took, how long the haptic
// thread waited for its turn. Looked at now and then from another core, kept for a while, and asked about a spike
// later.
//
// Thread: normal. Nothing is changed; what the kernel does not tell stays empty. Units in the names.
// Bound: the last kKept looks. Source: proc(5): /proc/interrupts, /proc/stat, /proc/PID/task/TID/schedstat.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "tools/timing/os_noise.h"

namespace tactus::timing {

// So far, on one core.
struct InterruptCounts {
  std::uint64_t timer{0};    // the kernel's local timer
  std::uint64_t devices{0};  // numbered lines
  std::uint64_t kernel{0};   // between cores and of the CPU itself: rescheduling, calls, page tables, machine checks
};

// The core's column; nothing where the text has none.
std::optional<InterruptCounts> parse_interrupts(const std::string& proc_interrupts, int cpu);
// "run wait slices" [ns]: the second, how long the thread was ready and another one ran.
std::optional<std::uint64_t> parse_wait_ns(const std::string& schedstat);

struct MachineLook {
  std::int64_t at_ns{0};
  std::optional<InterruptCounts> interrupts;
  std::optional<std::uint64_t> stolen_ms, waited_ns;
  std::optional<std::vector<Noise>> noise{};  // since the look before; nothing where nobody measures it
};

// Between two looks.
struct MachineChange {
  std::int64_t span_ns{0};
  std::optional<InterruptCounts> interrupts;
  std::optional<std::uint64_t> stolen_ms, waited_ns;
  std::optional<std::vector<Noise>> noise{};  // what overlaps the time that was asked about, cut to it
};

class MachineHistory {
 public:
  void add(const MachineLook& look);
  std::int64_t last_ns() const { return looks_.empty() ? 0 : looks_.back().at_ns; }
  // From the last look before `from` to the first one after `to`; nothing where they are not there.
  std::optional<MachineChange> around(std::int64_t from_ns, std::int64_t to_ns) const;

 private:
  static constexpr std::size_t kKept = 1000;
  std::deque<MachineLook> looks_;
};

// This machine, now. `thread_id`: of this process; 0: not known yet.
MachineLook look_at_machine(int cpu, int thread_id);

}  // namespace tactus::timing
