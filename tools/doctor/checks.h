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
MachineFinding check_kernel(const CheckContext& context);   // PREEMPT_RT
MachineFinding check_machine(const CheckContext& context);  // hardware or virtual machine
MachineFinding check_clock_source(const CheckContext& context);
MachineFinding check_throttling(const CheckContext& context);  // share of a second allowed for real-time threads
MachineFinding check_swap(const CheckContext& context);
MachineFinding check_huge_pages(const CheckContext& context);

// --- the chosen core (check_core.cpp)
MachineFinding check_cores(const CheckContext& context);        // enough cores, and the chosen one exists
MachineFinding check_isolation(const CheckContext& context);    // isolcpus
MachineFinding check_timer_ticks(const CheckContext& context);  // nohz_full
MachineFinding check_rcu(const CheckContext& context);          // rcu_nocbs
MachineFinding check_governor(const CheckContext& context);
MachineFinding check_idle_states(const CheckContext& context);  // C-states and /dev/cpu_dma_latency
MachineFinding check_sibling(const CheckContext& context);      // the other thread of the core
MachineFinding check_interrupts(const CheckContext& context);   // interrupts allowed on the core
MachineFinding check_smi(const CheckContext& context);          // firmware interrupts, invisible to the kernel

// --- the rights of this user (check_rights.cpp)
MachineFinding check_priority_limit(const CheckContext& context);
MachineFinding check_memory_limit(const CheckContext& context);
MachineFinding check_gpio(const CheckContext& context);

// --- the device's link (check_link.cpp)
MachineFinding check_usb(const CheckContext& context);
MachineFinding check_can(const CheckContext& context, const std::string& interface);
MachineFinding check_bus_interrupt(
    const CheckContext& context);  // core of the controller's interrupt; only if it has one
// Interrupt line numbers of the device's controller; empty: it has none, or no link was requested.
std::vector<std::string> bus_interrupt_lines(const CheckContext& context);

// --- helpers of all three
MachineFinding green(const char* check, std::string found);
MachineFinding amber(const char* check, std::string found, std::string remedy, std::string commands = {});
MachineFinding red(const char* check, std::string found, std::string remedy, std::string commands = {});
// The value of `name=` in /proc/cmdline; empty if absent.
std::optional<std::string> boot_parameter(const SystemView& system, const std::string& name);
bool contains(const std::vector<int>& cpus, int cpu);
std::string cpu_folder(int cpu);  // /sys/devices/system/cpu/cpuN

}  // namespace tactus::doctor
