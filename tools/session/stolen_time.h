// Reads the processor time that the host took from this virtual machine: the `steal` column of /proc/stat.
//
// Thread: normal; read before and after a run. Bound: a kernel that reports no steal reports 0, and a host may take
// time that it does not report. Source: proc(5).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace tactus::session {

struct CpuTime {
  std::uint64_t stolen{0}, all{0};  // in the kernel's ticks, since the machine started
};

// Of one core, or of all together (-1). Empty if the text has no such line.
std::optional<CpuTime> cpu_time(const std::string& proc_stat, int cpu);
// Of this machine, now.
std::optional<CpuTime> cpu_time_now(int cpu);
// 0 to 1; empty if one of the two is missing or no time has passed.
std::optional<double> stolen_share(const std::optional<CpuTime>& before, const std::optional<CpuTime>& after);

}  // namespace tactus::session
