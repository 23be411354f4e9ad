#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <sstream>

#include "tools/doctor/checks.h"

namespace tactus::doctor {
namespace {

// A register that counts system management interrupts since the start (Intel SDM vol. 4, MSR_SMI_COUNT).
constexpr std::uint64_t kSmiCounter = 0x34;
// Idle states with a longer exit latency visibly increase the wake-up latency.
constexpr long kQuickWake_us = 10;

// A separate file for each parameter, so that running the commands twice has no further effect.
std::string boot_with(const CheckContext& p, const char* parameter, const char* words = "") {
  return fmt::format(
      "mkdir -p /etc/default/grub.d && echo 'GRUB_CMDLINE_LINUX=\"$GRUB_CMDLINE_LINUX {0}={1}{2}\"' > "
      "/etc/default/grub.d/61-tactus-{0}.cfg && update-grub   # then reboot",
      parameter, words, p.cpu);
}

// True if the core is in the set that the kernel shows in this file; `shown` null: no such file, the boot line decides.
bool core_in(const CheckContext& p, const char* shown, const char* parameter) {
  if (const auto text = shown != nullptr ? p.system.read(shown) : std::nullopt)
    if (const auto cpus = parse_cpu_list(*text)) return contains(*cpus, p.cpu);
  auto value = boot_parameter(p.system, parameter);
  if (!value) return false;
  // isolcpus=managed_irq,domain,3: words stand before the numbers.
  std::string numbers;
  std::stringstream parts(*value);
  for (std::string part; std::getline(parts, part, ',');)
    if (!part.empty() && part.front() >= '0' && part.front() <= '9') numbers += (numbers.empty() ? "" : ",") + part;
  if (*value == "all") return true;
  const auto cpus = parse_cpu_list(numbers);
  return cpus && contains(*cpus, p.cpu);
}

}  // namespace

MachineFinding check_cores(const CheckContext& p) {
  const auto online = parse_cpu_list(p.system.read("/sys/devices/system/cpu/online").value_or(""));
  const std::uint32_t allowed = p.system.process().cpus_allowed;
  if (online && !online->empty() && !contains(*online, p.cpu))
    return red("cores", fmt::format("there is no cpu {} online", p.cpu),
               "choose another with --cpu, or bring it online", fmt::format("echo 1 > {}/online", cpu_folder(p.cpu)));
  const std::size_t count = online ? online->size() : allowed;
  if (count < 2)
    return red("cores", "one core only: the loop, the world and the kernel share it",
               "use a machine with at least two cores");
  if (allowed < 2)
    return red("cores", fmt::format("{} cores are online, this process may use {}", count, allowed),
               "take the restriction of the cpuset or of taskset away");
  if (count < 4)
    return amber("cores",
                 fmt::format("{} cores: the loop has one, the world shares the rest with the whole system", count),
                 "four cores or more leave one for the loop and one for the world");
  return green("cores", fmt::format("{} cores, the loop on cpu {}", count, p.cpu));
}

MachineFinding check_isolation(const CheckContext& p) {
  if (core_in(p, "/sys/devices/system/cpu/isolated", "isolcpus"))
    return green("isolation", fmt::format("cpu {} is kept free of other threads", p.cpu));
  return amber("isolation", fmt::format("cpu {} is shared: the scheduler may put any thread there", p.cpu),
               fmt::format("boot with isolcpus={}", p.cpu), boot_with(p, "isolcpus", "managed_irq,domain,"));
}

MachineFinding check_timer_ticks(const CheckContext& p) {
  if (core_in(p, "/sys/devices/system/cpu/nohz_full", "nohz_full"))
    return green("timer-ticks", fmt::format("the kernel's tick leaves cpu {} alone", p.cpu));
  return amber("timer-ticks", fmt::format("the kernel's tick interrupts cpu {} up to 1000 times a second", p.cpu),
               fmt::format("boot with nohz_full={}", p.cpu), boot_with(p, "nohz_full"));
}

MachineFinding check_rcu(const CheckContext& p) {
  // nohz_full implies it.
  if (core_in(p, nullptr, "rcu_nocbs") || core_in(p, "/sys/devices/system/cpu/nohz_full", "nohz_full"))
    return green("rcu", fmt::format("the kernel's deferred work runs elsewhere than on cpu {}", p.cpu));
  return amber("rcu", fmt::format("the kernel's deferred work may run on cpu {}", p.cpu),
               fmt::format("boot with rcu_nocbs={}", p.cpu), boot_with(p, "rcu_nocbs"));
}

MachineFinding check_governor(const CheckContext& p) {
  const std::string file = cpu_folder(p.cpu) + "/cpufreq/scaling_governor";
  const auto governor = p.system.read(file);
  if (!governor) return green("governor", "this kernel does not change the core's clock");
  if (*governor == "performance") return green("governor", "performance");
  return amber("governor", *governor + ": the core's clock follows its load, so the tick's time changes",
               "choose the governor performance", "echo performance > " + file);
}

MachineFinding check_idle_states(const CheckContext& p) {
  const std::string folder = cpu_folder(p.cpu) + "/cpuidle/";
  long slowest_us = 0;
  for (const std::string& state : p.system.list(folder)) {
    if (p.system.read(folder + state + "/disable").value_or("0") == "1") continue;
    const std::string text = p.system.read(folder + state + "/latency").value_or("0");
    long latency_us = 0;
    std::from_chars(text.data(), text.data() + text.size(), latency_us);
    slowest_us = std::max(slowest_us, latency_us);
  }
  if (slowest_us <= kQuickWake_us)
    return green("idle-states", fmt::format("the core wakes within {} us from its deepest sleep", slowest_us));
  if (p.system.writable("/dev/cpu_dma_latency"))
    return green("idle-states",
                 fmt::format("the core may take {} us to wake; /dev/cpu_dma_latency is writable, so a run "
                             "keeps it awake",
                             slowest_us));
  return red("idle-states",
             fmt::format("the core may take {} us to wake, and this user may not keep it awake", slowest_us),
             "make /dev/cpu_dma_latency writable for this user, or boot with processor.max_cstate=1",
             fmt::format("echo 'KERNEL==\"cpu_dma_latency\", MODE=\"0660\", OWNER=\"{}\"' > "
                         "/etc/udev/rules.d/61-tactus-latency.rules && udevadm control --reload && udevadm trigger",
                         p.system.process().user));
}

MachineFinding check_sibling(const CheckContext& p) {
  const auto text = p.system.read(cpu_folder(p.cpu) + "/topology/thread_siblings_list");
  auto siblings = parse_cpu_list(text.value_or(""));
  if (!text || !siblings)
    return amber("sibling", "the kernel does not say which cores share their hardware", "look with lscpu -e");
  std::erase(*siblings, p.cpu);
  if (siblings->empty()) return green("sibling", fmt::format("cpu {} shares its hardware with no other", p.cpu));
  const int other = siblings->front();
  const auto online = p.system.read(cpu_folder(other) + "/online");
  if (online == "0") return green("sibling", fmt::format("cpu {}, which shares the core, is offline", other));
  return amber(
      "sibling",
      fmt::format("cpu {} shares the core's hardware: what runs there makes the tick up to twice as long", other),
      fmt::format("take cpu {} offline, or leave it idle", other),
      fmt::format("echo 0 > {}/online", cpu_folder(other)));
}

MachineFinding check_interrupts(const CheckContext& p) {
  std::string numbers, commands;
  int count = 0;
  const std::vector<std::string> of_bus = bus_interrupt_lines(p);
  for (const std::string& number : p.system.list("/proc/irq")) {
    if (number.empty() || number.front() < '0' || number.front() > '9') continue;
    if (std::find(of_bus.begin(), of_bus.end(), number) != of_bus.end()) continue;  // see bus-interrupt
    const std::string folder = "/proc/irq/" + number;
    // The last chosen affinity; it takes effect at the next interrupt.
    const auto allowed = parse_cpu_list(p.system.read(folder + "/smp_affinity_list").value_or(""));
    const auto effective = p.system.read(folder + "/effective_affinity_list");
    const auto now = effective && !effective->empty() ? parse_cpu_list(*effective) : allowed;
    // The folder of a number that no driver uses contains only files.
    const auto entries = p.system.list(folder);
    const bool used = std::any_of(entries.begin(), entries.end(), [&](const std::string& e) {
      return e != "smp_affinity" && e != "smp_affinity_list" && e != "effective_affinity" &&
             e != "effective_affinity_list" && e != "affinity_hint" && e != "node" && e != "spurious";
    });
    if (!used || !allowed || !now || !contains(*allowed, p.cpu) || !contains(*now, p.cpu)) continue;
    if (++count <= 8) numbers += (numbers.empty() ? "" : ", ") + number;
    commands +=
        fmt::format("{}echo {} > {}/smp_affinity_list", commands.empty() ? "" : "\n", p.cpu == 0 ? 1 : 0, folder);
  }
  if (count == 0) return green("interrupts", fmt::format("no device's interrupt goes to cpu {}", p.cpu));
  return amber(
      "interrupts",
      fmt::format("{} devices' interrupts go to cpu {}: {}{}", count, p.cpu, numbers, count > 8 ? ", ..." : ""),
      fmt::format("send them to another core, and switch irqbalance off; for those that refuse boot with "
                  "isolcpus=managed_irq,domain,{}",
                  p.cpu),
      commands);
}

MachineFinding check_smi(const CheckContext& p) {
  const std::string file = fmt::format("/dev/cpu/{}/msr", p.cpu);
  const auto count = p.system.read_word(file, kSmiCounter);
  if (!count)
    return amber("firmware-interrupts", "cannot be counted: " + file + " is not there, or not readable",
                 "load the module msr and ask again as root; on a CPU that is not Intel's leave it", "modprobe msr");
  if (*count == 0) return green("firmware-interrupts", "none since the start");
  return amber(
      "firmware-interrupts",
      fmt::format("{} since the start: the board's firmware stops all cores, and no kernel sees it", *count),
      "switch legacy USB, power and fan management off in the firmware's set-up; watch whether the count grows");
}

}  // namespace tactus::doctor
