// The doctor's checks, one function each; see examine.h for what a finding is. Thread: normal.
#pragma once

#include "tools/doctor/examine.h"

namespace tactus::doctor {

// Input of a check: the system, the request, and the chosen core.
struct CheckContext {
  const SystemView& system;
  const Request& request;
  int cpu{0};
};

// --- the kernel (check_kernel.cpp)
Finding check_kernel(const CheckContext& context);   // PREEMPT_RT
Finding check_machine(const CheckContext& context);  // hardware or virtual machine
Finding check_clock_source(const CheckContext& context);
Finding check_throttling(const CheckContext& context);  // share of a second allowed for real-time threads
Finding check_swap(const CheckContext& context);
Finding check_huge_pages(const CheckContext& context);

// --- the chosen core (check_core.cpp)
Finding check_cores(const CheckContext& context);        // enough cores, and the chosen one exists
Finding check_isolation(const CheckContext& context);    // isolcpus
Finding check_timer_ticks(const CheckContext& context);  // nohz_full
Finding check_rcu(const CheckContext& context);          // rcu_nocbs
Finding check_governor(const CheckContext& context);
Finding check_idle_states(const CheckContext& context);  // C-states and /dev/cpu_dma_latency
Finding check_sibling(const CheckContext& context);      // the other thread of the core
Finding check_interrupts(const CheckContext& context);   // interrupts allowed on the core
Finding check_smi(const CheckContext& context);          // firmware interrupts, invisible to the kernel

// --- the rights of this user (check_rights.cpp)
Finding check_priority_limit(const CheckContext& context);
Finding check_memory_limit(const CheckContext& context);
Finding check_gpio(const CheckContext& context);

// --- the device's link (check_link.cpp)
Finding check_usb(const CheckContext& context);
Finding check_can(const CheckContext& context, const std::string& interface);
Finding check_bus_interrupt(const CheckContext& context);  // core of the controller's interrupt; only if it has one
// Interrupt line numbers of the device's controller; empty: it has none, or no link was requested.
std::vector<std::string> bus_interrupt_lines(const CheckContext& context);

// --- helpers of all three
Finding green(const char* check, std::string found);
Finding amber(const char* check, std::string found, std::string remedy, std::string commands = {});
Finding red(const char* check, std::string found, std::string remedy, std::string commands = {});
// The value of `name=` in /proc/cmdline; empty if absent.
std::optional<std::string> boot_parameter(const SystemView& system, const std::string& name);
bool contains(const std::vector<int>& cpus, int cpu);
std::string cpu_folder(int cpu);  // /sys/devices/system/cpu/cpuN

}  // namespace tactus::doctor
