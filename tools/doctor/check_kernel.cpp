#include <fmt/format.h>

#include <charconv>

#include "tools/doctor/checks.h"

namespace tactus::doctor {
namespace {

std::optional<long long> number_in(const SystemView& system, const std::string& path) {
  const auto text = system.read(path);
  if (!text) return std::nullopt;
  long long number = 0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), number);
  if (error != std::errc{} || end == text->data()) return std::nullopt;
  return number;
}

// The word in brackets of "always [madvise] never".
std::string chosen_word(const std::string& text) {
  const auto open = text.find('['), close = text.find(']');
  return open != std::string::npos && close != std::string::npos && close > open
             ? text.substr(open + 1, close - open - 1)
             : text;
}

}  // namespace

// /sys/kernel/realtime is not present in every PREEMPT_RT kernel (the patch has it, the mainline kernel does not); if
// it is missing, the version text decides.
MachineFinding check_kernel(const CheckContext& context) {
  const std::string version = context.system.read("/proc/version").value_or("");
  const std::string release = context.system.read("/proc/sys/kernel/osrelease").value_or("an unknown kernel");
  const auto flag = context.system.read("/sys/kernel/realtime");
  const bool by_version =
      version.find("PREEMPT_RT") != std::string::npos || version.find("PREEMPT RT") != std::string::npos;
  if (flag ? *flag == "1" : by_version) return green("kernel", release + " is a PREEMPT_RT kernel");
  MachineFinding finding =
      red("kernel", release + " is not a PREEMPT_RT kernel: any wake-up may come milliseconds late",
          "install and boot a PREEMPT_RT kernel (Debian: linux-image-rt-amd64)",
          "apt install linux-image-rt-amd64   # then reboot");
  finding.distorts = true;
  return finding;
}

MachineFinding check_machine(const CheckContext& context) {
  const std::string cpuinfo = context.system.read("/proc/cpuinfo").value_or("");
  const auto at = cpuinfo.find("model name");
  std::string model = "an unknown CPU";
  if (at != std::string::npos) {
    const auto colon = cpuinfo.find(": ", at), end = cpuinfo.find('\n', at);
    if (colon != std::string::npos && colon < end) model = cpuinfo.substr(colon + 2, end - colon - 2);
  }
  const auto flags = cpuinfo.find("\nflags");
  const std::string flag_line =
      flags == std::string::npos ? "" : cpuinfo.substr(flags, cpuinfo.find('\n', flags + 1) - flags);
  if ((flag_line + " ").find(" hypervisor ") == std::string::npos) return green("machine", model);
  MachineFinding finding =
      amber("machine", model + ", in a virtual machine: its host takes the cores away at will",
            "run on hardware; a guest needs cores pinned to it, and shows its host's gaps as its own");
  finding.distorts = true;
  return finding;
}

MachineFinding check_clock_source(const CheckContext& context) {
  const std::string folder = "/sys/devices/system/clocksource/clocksource0/";
  const auto now = context.system.read(folder + "current_clocksource");
  if (!now) return amber("clock", "the clock source cannot be read", "see whether /sys is mounted");
  // Clock sources that a program can read without a system call.
  if (*now == "tsc" || *now == "kvm-clock" || *now == "arch_sys_counter" || *now == "hyperv_clocksource_tsc_page")
    return green("clock", *now + ": read in nanoseconds, without the kernel");
  const bool has_tsc =
      context.system.read(folder + "available_clocksource").value_or("").find("tsc") != std::string::npos;
  return amber("clock", *now + " is slow to read: each look at the time costs about a microsecond",
               has_tsc ? "boot with clocksource=tsc, or find in dmesg why the kernel gave the TSC up"
                       : "this machine has no steady time-stamp counter: choose another for real-time work",
               has_tsc ? "echo tsc > " + folder + "current_clocksource" : "");
}

MachineFinding check_throttling(const CheckContext& context) {
  const auto runtime_us = number_in(context.system, "/proc/sys/kernel/sched_rt_runtime_us");
  const auto period_us = number_in(context.system, "/proc/sys/kernel/sched_rt_period_us");
  if (!runtime_us || !period_us) return green("throttling", "this kernel has no limit on real-time threads");
  if (*runtime_us < 0 || *runtime_us >= *period_us) return green("throttling", "real-time threads are never held back");
  return amber("throttling",
               fmt::format("real-time threads get at most {} of {} ms: one that fills its periods is stopped for {} ms",
                           *runtime_us / 1000, *period_us / 1000, (*period_us - *runtime_us) / 1000),
               "lift the limit: sysctl kernel.sched_rt_runtime_us=-1",
               "sysctl -w kernel.sched_rt_runtime_us=-1\n"
               "echo 'kernel.sched_rt_runtime_us = -1' > /etc/sysctl.d/61-tactus-throttling.conf");
}

MachineFinding check_swap(const CheckContext& context) {
  const auto swaps = context.system.read("/proc/swaps");
  if (!swaps || swaps->find('\n') == std::string::npos) return green("swap", "none");
  return amber("swap", "is on: pages that nobody locked may be on the disk when they are needed",
               "switch it off, or rely on the memory lock (see memory-limit)", "swapoff -a");
}

MachineFinding check_huge_pages(const CheckContext& context) {
  const auto text = context.system.read("/sys/kernel/mm/transparent_hugepage/enabled");
  if (!text) return green("huge-pages", "this kernel makes none by itself");
  const std::string chosen = chosen_word(*text);
  if (chosen != "always") return green("huge-pages", "made only where a program asks (" + chosen + ")");
  return amber("huge-pages", "made at will (always): the kernel may stop a thread to move its pages together",
               "set transparent huge pages to madvise", "echo madvise > /sys/kernel/mm/transparent_hugepage/enabled");
}

}  // namespace tactus::doctor
