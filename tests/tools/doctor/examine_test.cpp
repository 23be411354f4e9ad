// The doctor on recorded trees: a healthy PC, and the same PC with one thing wrong at a time.
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "tools/doctor/examine.h"

using namespace tactus;
using namespace tactus::doctor;

namespace {

// A tree in the temporary folder, removed with the object. At first a PC that needs no action, with CPU 3 for the loop.
class Tree {
 public:
  Tree() {
    std::string name = (std::filesystem::temp_directory_path() / "tactus-doctor-XXXXXX").string();
    REQUIRE(mkdtemp(name.data()) != nullptr);
    root = name;
    write("process", "user ada\nrtprio_limit 98\nmemlock_limit_B unlimited\ncpus_allowed 4\nlast_allowed_cpu 3\n");
    write("proc/version", "Linux version 6.1.0-rt #1 SMP PREEMPT_RT\n");
    write("proc/sys/kernel/osrelease", "6.1.0-rt\n");
    write("proc/cpuinfo", "model name\t: Some CPU\nflags\t\t: fpu avx2\n");
    write("proc/cmdline", "quiet isolcpus=managed_irq,domain,3 nohz_full=3 rcu_nocbs=3\n");
    write("proc/swaps", "Filename Type Size Used Priority\n");
    write("proc/sys/kernel/sched_rt_runtime_us", "-1\n");
    write("proc/sys/kernel/sched_rt_period_us", "1000000\n");
    write("sys/kernel/realtime", "1\n");
    write("sys/kernel/mm/transparent_hugepage/enabled", "always [madvise] never\n");
    write("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc\n");
    write("sys/devices/system/clocksource/clocksource0/available_clocksource", "tsc hpet\n");
    write("sys/devices/system/cpu/online", "0-3\n");
    write("sys/devices/system/cpu/isolated", "3\n");
    write("sys/devices/system/cpu/nohz_full", "3\n");
    write("sys/devices/system/cpu/cpu3/cpufreq/scaling_governor", "performance\n");
    write("sys/devices/system/cpu/cpu3/cpuidle/state0/latency", "0\n");
    write("sys/devices/system/cpu/cpu3/cpuidle/state1/latency", "2\n");
    write("sys/devices/system/cpu/cpu3/topology/thread_siblings_list", "3\n");
    write("proc/irq/24/smp_affinity_list", "0-2\n");
    write("proc/irq/24/eth0/none", "");
    write("dev/cpu/3/msr", std::string(0x34 + 8, '\0'));  // counter of firmware interrupts: none
    write("proc/irq/7/smp_affinity_list", "0-3\n");       // no driver uses it
  }
  ~Tree() { std::filesystem::remove_all(root); }

  void write(const std::string& path, const std::string& text) const {
    std::filesystem::create_directories((root / path).parent_path());
    std::ofstream(root / path, std::ios::binary) << text;
  }
  void remove(const std::string& path) const { std::filesystem::remove_all(root / path); }

  Report examine(Request request = {}) const {
    const auto system = SystemView::open(root);
    REQUIRE(system.ok());
    return doctor::examine(system.value(), request);
  }

  std::filesystem::path root;
};

const MachineFinding& of(const Report& report, const std::string& check) {
  for (const MachineFinding& finding : report.findings)
    if (finding.check == check) return finding;
  FAIL("no finding of " << check);
  throw 0;  // not reached
}

// Only the check of this name is not green.
void only(const Tree& tree, const std::string& check, MachineVerdict verdict) {
  const Report report = tree.examine();
  for (const MachineFinding& finding : report.findings) {
    INFO(finding.check << ": " << finding.found);
    CHECK(finding.verdict == (finding.check == check ? verdict : MachineVerdict::kGreen));
    CHECK(finding.remedy.empty() == (finding.verdict == MachineVerdict::kGreen));
  }
  CHECK(of(report, check).verdict == verdict);
}

}  // namespace

TEST_CASE("A PC that needs no action is green in every check, and its figures are representative") {
  const Tree tree;
  const Report report = tree.examine();
  for (const MachineFinding& finding : report.findings) {
    INFO(finding.check << ": " << finding.found);
    CHECK(finding.verdict == MachineVerdict::kGreen);
    CHECK_FALSE(finding.found.empty());
    CHECK(finding.remedy.empty());
  }
  CHECK(report.findings.size() == 17);
  CHECK(report.cpu == 3);
  CHECK(report.worst() == MachineVerdict::kGreen);
  CHECK(report.representative());
}

TEST_CASE("A kernel without PREEMPT_RT is red and distorts the figures") {
  const Tree tree;
  tree.write("sys/kernel/realtime", "0\n");
  only(tree, "kernel", MachineVerdict::kRed);
  CHECK_FALSE(tree.examine().representative());
}

TEST_CASE("A real-time kernel without the flag in sysfs is known by its version") {
  const Tree tree;
  tree.remove("sys/kernel/realtime");
  CHECK(of(tree.examine(), "kernel").verdict == MachineVerdict::kGreen);
  tree.write("proc/version", "Linux version 6.1.0 #1 SMP PREEMPT_DYNAMIC\n");
  only(tree, "kernel", MachineVerdict::kRed);
}

TEST_CASE("A virtual machine is amber and distorts the figures") {
  const Tree tree;
  tree.write("proc/cpuinfo", "model name\t: Some CPU\nflags\t\t: fpu avx2 hypervisor\n");
  only(tree, "machine", MachineVerdict::kAmber);
  CHECK_FALSE(tree.examine().representative());
}

TEST_CASE("A slow clock source is amber, and the remedy names the quick one where there is one") {
  const Tree tree;
  tree.write("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet\n");
  only(tree, "clock", MachineVerdict::kAmber);
  CHECK(of(tree.examine(), "clock").commands.find("echo tsc") != std::string::npos);
  tree.write("sys/devices/system/clocksource/clocksource0/available_clocksource", "hpet acpi_pm\n");
  CHECK(of(tree.examine(), "clock").commands.empty());
}

TEST_CASE("A limit on real-time threads is amber and says how long they stop") {
  const Tree tree;
  tree.write("proc/sys/kernel/sched_rt_runtime_us", "950000\n");
  only(tree, "throttling", MachineVerdict::kAmber);
  CHECK(of(tree.examine(), "throttling").found.find("50 ms") != std::string::npos);
}

TEST_CASE("Swap and huge pages made at will are amber") {
  const Tree swap;
  swap.write("proc/swaps", "Filename Type Size Used Priority\n/dev/sda2 partition 8 0 -2\n");
  only(swap, "swap", MachineVerdict::kAmber);
  const Tree pages;
  pages.write("sys/kernel/mm/transparent_hugepage/enabled", "[always] madvise never\n");
  only(pages, "huge-pages", MachineVerdict::kAmber);
}

TEST_CASE("One core is red, two are amber, a core that is not there is red") {
  const Tree one;
  one.write("sys/devices/system/cpu/online", "3\n");
  only(one, "cores", MachineVerdict::kRed);
  const Tree two;
  two.write("sys/devices/system/cpu/online", "0,3\n");
  only(two, "cores", MachineVerdict::kAmber);
  const Tree other;
  Request request;
  request.cpu = 9;
  CHECK(of(other.examine(request), "cores").verdict == MachineVerdict::kRed);
}

TEST_CASE("A process that may use one core only is red though there are more") {
  const Tree tree;
  tree.write("process", "user ada\nrtprio_limit 98\nmemlock_limit_B unlimited\ncpus_allowed 1\nlast_allowed_cpu 3\n");
  only(tree, "cores", MachineVerdict::kRed);
}

TEST_CASE("A core that is not isolated, ticks or does deferred work is amber each time") {
  const Tree isolated;
  isolated.write("sys/devices/system/cpu/isolated", "\n");
  only(isolated, "isolation", MachineVerdict::kAmber);

  const Tree ticks;
  ticks.write("sys/devices/system/cpu/nohz_full", "1-2\n");
  only(ticks, "timer-ticks", MachineVerdict::kAmber);

  const Tree rcu;
  rcu.write("sys/devices/system/cpu/nohz_full", "\n");
  rcu.write("proc/cmdline", "quiet isolcpus=3 rcu_nocbs=0-2\n");
  const Report report = rcu.examine();
  CHECK(of(report, "rcu").verdict == MachineVerdict::kAmber);
  CHECK(of(report, "rcu").commands.find("rcu_nocbs=3") != std::string::npos);
}

TEST_CASE("Where the kernel shows no set of isolated cores the boot line decides") {
  const Tree tree;
  tree.remove("sys/devices/system/cpu/isolated");
  CHECK(of(tree.examine(), "isolation").verdict == MachineVerdict::kGreen);
  tree.write("proc/cmdline", "quiet isolcpus=managed_irq,domain,2 nohz_full=3 rcu_nocbs=3\n");
  only(tree, "isolation", MachineVerdict::kAmber);
}

TEST_CASE("A governor that follows the load is amber") {
  const Tree tree;
  tree.write("sys/devices/system/cpu/cpu3/cpufreq/scaling_governor", "powersave\n");
  only(tree, "governor", MachineVerdict::kAmber);
}

TEST_CASE("A deep sleep is red unless the user may keep the core awake or the state is switched off") {
  const Tree tree;
  tree.write("sys/devices/system/cpu/cpu3/cpuidle/state3/latency", "133\n");
  only(tree, "idle-states", MachineVerdict::kRed);
  tree.write("sys/devices/system/cpu/cpu3/cpuidle/state3/disable", "1\n");
  CHECK(of(tree.examine(), "idle-states").verdict == MachineVerdict::kGreen);
  tree.write("sys/devices/system/cpu/cpu3/cpuidle/state3/disable", "0\n");
  tree.write("dev/cpu_dma_latency", "");
  CHECK(of(tree.examine(), "idle-states").verdict == MachineVerdict::kGreen);
}

TEST_CASE("A busy sibling is amber, an offline one is not") {
  const Tree tree;
  tree.write("sys/devices/system/cpu/cpu3/topology/thread_siblings_list", "1,3\n");
  only(tree, "sibling", MachineVerdict::kAmber);
  tree.write("sys/devices/system/cpu/cpu1/online", "0\n");
  CHECK(of(tree.examine(), "sibling").verdict == MachineVerdict::kGreen);
}

TEST_CASE("An interrupt in use that may come to the core is amber, and only that one is named") {
  const Tree tree;
  tree.write("proc/irq/31/smp_affinity_list", "0-3\n");
  tree.write("proc/irq/31/xhci_hcd/none", "");
  only(tree, "interrupts", MachineVerdict::kAmber);
  const MachineFinding finding = of(tree.examine(), "interrupts");
  CHECK(finding.found.find("31") != std::string::npos);
  CHECK(finding.found.find("24") == std::string::npos);
  tree.write("proc/irq/31/effective_affinity_list", "2\n");  // what is really used counts
  CHECK(of(tree.examine(), "interrupts").verdict == MachineVerdict::kGreen);
  // Sent elsewhere: it goes with its next interrupt.
  tree.write("proc/irq/31/effective_affinity_list", "3\n");
  CHECK(of(tree.examine(), "interrupts").verdict == MachineVerdict::kAmber);
  tree.write("proc/irq/31/smp_affinity_list", "0-2\n");
  CHECK(of(tree.examine(), "interrupts").verdict == MachineVerdict::kGreen);
}

TEST_CASE("Firmware interrupts that were counted are amber") {
  const Tree tree;
  std::string registers(0x34 + 8, '\0');
  tree.write("dev/cpu/3/msr", registers);
  CHECK(of(tree.examine(), "firmware-interrupts").verdict == MachineVerdict::kGreen);
  registers[0x34] = 12;
  tree.write("dev/cpu/3/msr", registers);
  only(tree, "firmware-interrupts", MachineVerdict::kAmber);
  CHECK(of(tree.examine(), "firmware-interrupts").found.find("12 since") != std::string::npos);
  tree.remove("dev/cpu");
  only(tree, "firmware-interrupts", MachineVerdict::kAmber);
}

TEST_CASE("Limits that are too low are red, and a capability makes up for them") {
  const Tree tree;
  tree.write("process", "user ada\nrtprio_limit 0\nmemlock_limit_B unlimited\ncpus_allowed 4\nlast_allowed_cpu 3\n");
  only(tree, "priority-limit", MachineVerdict::kRed);
  tree.write("process", "user ada\nrtprio_limit 98\nmemlock_limit_B 8388608\ncpus_allowed 4\nlast_allowed_cpu 3\n");
  only(tree, "memory-limit", MachineVerdict::kRed);
  tree.write(
      "process",
      "user ada\nmay_set_priority 1\nmay_lock_memory 1\nmemlock_limit_B 0\ncpus_allowed 4\nlast_allowed_cpu 3\n");
  CHECK(tree.examine().worst() == MachineVerdict::kGreen);
}

TEST_CASE("A device on USB must be there and usable") {
  const Tree tree;
  Request request;
  request.usb = true;
  CHECK(of(tree.examine(request), "usb").verdict == MachineVerdict::kRed);
  tree.write("sys/bus/usb/devices/1-2/idVendor", "1209\n");
  tree.write("sys/bus/usb/devices/1-2/idProduct", "0001\n");
  tree.write("sys/bus/usb/devices/1-2/busnum", "1\n");
  tree.write("sys/bus/usb/devices/1-2/devnum", "7\n");
  const MachineFinding refused = of(tree.examine(request), "usb");
  CHECK(refused.verdict == MachineVerdict::kRed);
  CHECK(refused.commands.find("ATTR{idVendor}==\"1209\"") != std::string::npos);
  tree.write("dev/bus/usb/001/007", "");
  CHECK(of(tree.examine(request), "usb").verdict == MachineVerdict::kGreen);
}

TEST_CASE("The interrupt of the device's bus is amber while it may come to many cores, and may come to the loop's") {
  const Tree tree;
  Request request;
  request.can_interfaces = {"can0"};
  for (const MachineFinding& finding : tree.examine(request).findings)
    CHECK(finding.check != "bus-interrupt");  // none shown
  tree.write("sys/class/net/can0/device/irq", "16\n");
  tree.write("proc/irq/16/smp_affinity_list", "0-3\n");
  tree.write("proc/irq/16/can0/none", "");
  const MachineFinding spread = of(tree.examine(request), "bus-interrupt");
  CHECK(spread.verdict == MachineVerdict::kAmber);
  CHECK(spread.commands == "echo 3 > /proc/irq/16/smp_affinity_list");
  tree.write("proc/irq/16/smp_affinity_list", "3\n");
  CHECK(of(tree.examine(request), "bus-interrupt").verdict == MachineVerdict::kGreen);
  CHECK(of(tree.examine(request), "interrupts").verdict == MachineVerdict::kGreen);
  only(tree, "interrupts", MachineVerdict::kAmber);  // of a link that is not in the request
}

TEST_CASE("The interrupts of a device on USB are its controller's") {
  const Tree tree;
  Request request;
  request.usb = true;
  tree.write("sys/bus/usb/devices/1-2/idVendor", "1209\n");
  tree.write("sys/bus/usb/devices/1-2/idProduct", "0001\n");
  tree.write("sys/bus/usb/devices/1-2/busnum", "1\n");
  tree.write("sys/devices/pci0/usb1/busnum", "1\n");
  tree.write("sys/devices/pci0/irq", "16\n");
  tree.write("sys/devices/pci0/msi_irqs/29", "msi\n");
  std::filesystem::create_directory_symlink(tree.root / "sys/devices/pci0/usb1",
                                            tree.root / "sys/bus/usb/devices/usb1");
  tree.write("proc/irq/29/smp_affinity_list", "0-3\n");
  tree.write("proc/irq/29/xhci_hcd/none", "");
  CHECK(of(tree.examine(request), "bus-interrupt").commands == "echo 3 > /proc/irq/29/smp_affinity_list");
  request.usb = false;
  request.can_interfaces = {"can0"};  // an adapter on that bus
  tree.write("sys/devices/pci0/usb1/1-3/busnum", "1\n");
  std::filesystem::create_directories(tree.root / "sys/devices/pci0/usb1/1-3/1-3:1.0");
  std::filesystem::create_directories(tree.root / "sys/class/net/can0");
  std::filesystem::create_directory_symlink(tree.root / "sys/devices/pci0/usb1/1-3/1-3:1.0",
                                            tree.root / "sys/class/net/can0/device");
  CHECK(of(tree.examine(request), "bus-interrupt").verdict == MachineVerdict::kAmber);
}

TEST_CASE("What removes the findings is a shell script, and nothing in it ends the machine's run half way") {
  const Tree tree;
  tree.write("process", "user ada\nrtprio_limit 0\nmemlock_limit_B 0\ncpus_allowed 4\nlast_allowed_cpu 3\n");
  for (const char* file : {"sys/devices/system/cpu/isolated", "sys/devices/system/cpu/nohz_full", "proc/cmdline",
                           "sys/devices/system/cpu/online", "sys/kernel/realtime"})
    tree.write(file, "0\n");
  tree.write("proc/sys/kernel/sched_rt_runtime_us", "950000\n");
  tree.write("proc/swaps", "Filename Type Size Used Priority\n/dev/sda2 partition 8 0 -2\n");
  tree.write("sys/kernel/mm/transparent_hugepage/enabled", "[always] madvise never\n");
  tree.write("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet\n");
  tree.write("sys/devices/system/cpu/cpu3/cpufreq/scaling_governor", "powersave\n");
  tree.write("sys/devices/system/cpu/cpu3/cpuidle/state3/latency", "133\n");
  tree.write("sys/devices/system/cpu/cpu3/topology/thread_siblings_list", "1,3\n");
  tree.write("proc/irq/31/smp_affinity_list", "0-3\n");
  tree.write("proc/irq/31/eth0/none", "");
  tree.remove("dev/cpu");
  Request request;
  request.usb = request.gpio = true;
  tree.write("dev/gpiochip0", "");
  std::filesystem::permissions(tree.root / "dev/gpiochip0", std::filesystem::perms::none);
  tree.write("sys/bus/usb/devices/1-2/idVendor", "1209\n");
  tree.write("sys/bus/usb/devices/1-2/idProduct", "0001\n");
  int with_commands = 0;
  for (const MachineFinding& finding : tree.examine(request).findings) {
    if (finding.commands.empty()) continue;
    ++with_commands;
    INFO(finding.check << ": " << finding.commands);
    std::istringstream lines(finding.commands);
    for (std::string line; std::getline(lines, line);) {
      const std::string first = line.substr(0, line.find(' '));
      const std::string known = " apt echo ip mkdir modprobe swapoff sysctl ";
      CHECK(known.find(" " + first + " ") != std::string::npos);
      CHECK(line.substr(0, line.find(" #")).find("reboot") == std::string::npos);
    }
    tree.write("remedy.sh", finding.commands + "\n");
    CHECK(std::system(("sh -n " + (tree.root / "remedy.sh").string()).c_str()) == 0);
  }
  CHECK(with_commands >= 15);
}

TEST_CASE("GPIO lines must be there and usable") {
  const Tree tree;
  Request request;
  request.gpio = true;
  CHECK(of(tree.examine(request), "gpio").verdict == MachineVerdict::kRed);
  tree.write("dev/gpiochip0", "");
  CHECK(of(tree.examine(request), "gpio").verdict == MachineVerdict::kGreen);
}

TEST_CASE("Sets of cores are read as the kernel writes them, and nothing else is") {
  CHECK(parse_cpu_list("0-2,5") == std::vector<int>{0, 1, 2, 5});
  CHECK(parse_cpu_list("").value().empty());
  for (const char* bad : {"a", "1-", "3-1", "-1", "1,,2", "1 2"}) {
    INFO(bad);
    CHECK_FALSE(parse_cpu_list(bad).has_value());
  }
}

TEST_CASE("A recorded tree that is none, or has facts that are none, is refused in one line") {
  CHECK_FALSE(SystemView::open("no/such/tree").ok());
  const Tree tree;
  tree.write("process", "rtprio_limit many\n");
  const auto wrong_value = SystemView::open(tree.root);
  REQUIRE_FALSE(wrong_value.ok());
  CHECK(wrong_value.message().find("'many' is no number; accepted: digits or unlimited") != std::string::npos);
  tree.write("process", "rtprio 98\n");
  REQUIRE_FALSE(SystemView::open(tree.root).ok());
  CHECK(SystemView::open(tree.root).message().find("no such fact: rtprio; accepted:") != std::string::npos);
}

TEST_CASE("On this machine every check finds something to say") {
  const auto system = SystemView::open("/");
  REQUIRE(system.ok());
  const Report report = examine(system.value(), {});
  CHECK(report.findings.size() == 17);
  for (const MachineFinding& finding : report.findings) {
    INFO(finding.check);
    CHECK_FALSE(finding.found.empty());
    CHECK(finding.remedy.empty() == (finding.verdict == MachineVerdict::kGreen));
  }
}
