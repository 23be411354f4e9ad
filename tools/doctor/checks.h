// The doctor's checks, one function each; see examine.h for what a finding is. Thread: normal.
#pragma once

#include "tools/doctor/examine.h"

namespace tactus::doctor {

// What a check looks at: the system, what was asked, and the core that was chosen.
struct Patient {
  const SystemView& system;
  const Request& request;
  int cpu{0};
};

// --- the kernel (check_kernel.cpp)
Finding check_kernel(const Patient& patient);   // PREEMPT_RT
Finding check_machine(const Patient& patient);  // hardware, or a guest of somebody's
Finding check_clock_source(const Patient& patient);
Finding check_throttling(const Patient& patient);  // the share of a second that real-time threads may use
Finding check_swap(const Patient& patient);
Finding check_huge_pages(const Patient& patient);

// --- the chosen core (check_core.cpp)
Finding check_cores(const Patient& patient);        // enough of them, and the chosen one there
Finding check_isolation(const Patient& patient);    // isolcpus
Finding check_timer_ticks(const Patient& patient);  // nohz_full
Finding check_rcu(const Patient& patient);          // rcu_nocbs
Finding check_governor(const Patient& patient);
Finding check_idle_states(const Patient& patient);  // C-states and /dev/cpu_dma_latency
Finding check_sibling(const Patient& patient);      // the other thread of the core
Finding check_interrupts(const Patient& patient);   // which may come to the core
Finding check_smi(const Patient& patient);          // firmware interrupts, which no kernel sees

// --- what this user may do (check_rights.cpp)
Finding check_priority_limit(const Patient& patient);
Finding check_memory_limit(const Patient& patient);
Finding check_gpio(const Patient& patient);

// --- the device's link (check_link.cpp)
Finding check_usb(const Patient& patient);
Finding check_can(const Patient& patient);
Finding check_bus_interrupt(const Patient& patient);  // where that of its controller goes; only if it has one
// The numbers of the lines of the controller that the device is on; none: it has none, or no link was asked about.
std::vector<std::string> bus_interrupt_lines(const Patient& patient);

// --- helpers of all three
Finding green(const char* check, std::string found);
Finding amber(const char* check, std::string found, std::string cure, std::string commands = {});
Finding red(const char* check, std::string found, std::string cure, std::string commands = {});
// The value of `name=` in /proc/cmdline, or nothing.
std::optional<std::string> boot_parameter(const SystemView& system, const std::string& name);
bool contains(const std::vector<int>& cpus, int cpu);
std::string cpu_folder(int cpu);  // /sys/devices/system/cpu/cpuN

}  // namespace tactus::doctor
