#include "tools/doctor/examine.h"

#include <algorithm>
#include <array>
#include <sstream>

#include "tools/doctor/checks.h"

namespace tactus::doctor {
namespace {

using Check = MachineFinding (*)(const CheckContext&);

constexpr std::array<Check, 17> kAlways{check_kernel,      check_machine,    check_clock_source, check_throttling,
                                        check_swap,        check_huge_pages, check_cores,        check_isolation,
                                        check_timer_ticks, check_rcu,        check_governor,     check_idle_states,
                                        check_sibling,     check_interrupts, check_smi,          check_priority_limit,
                                        check_memory_limit};

}  // namespace

Report examine(const SystemView& system, const Request& request) {
  Report report;
  report.cpu = request.cpu >= 0 ? request.cpu : std::max(system.process().last_allowed_cpu, 0);
  const CheckContext context{system, request, report.cpu};
  for (const Check check : kAlways) report.findings.push_back(check(context));
  if (request.usb) report.findings.push_back(check_usb(context));
  for (const std::string& interface : request.can_interfaces) report.findings.push_back(check_can(context, interface));
  if (!bus_interrupt_lines(context).empty()) report.findings.push_back(check_bus_interrupt(context));
  if (request.gpio) report.findings.push_back(check_gpio(context));
  return report;
}

bool Report::representative() const {
  return std::none_of(findings.begin(), findings.end(), [](const MachineFinding& f) { return f.distorts; });
}

MachineVerdict Report::worst() const {
  MachineVerdict worst = MachineVerdict::kGreen;
  for (const MachineFinding& finding : findings) worst = std::max(worst, finding.verdict);
  return worst;
}

const char* name_of(MachineVerdict verdict) {
  constexpr std::array<const char*, 3> names{"green", "amber", "red"};
  return names[static_cast<std::size_t>(verdict)];
}

MachineFinding green(const char* check, std::string found) {
  return {.check = check,
          .verdict = MachineVerdict::kGreen,
          .found = std::move(found),
          .remedy = {},
          .commands = {},
          .distorts = false};
}

MachineFinding amber(const char* check, std::string found, std::string remedy, std::string commands) {
  return {.check = check,
          .verdict = MachineVerdict::kAmber,
          .found = std::move(found),
          .remedy = std::move(remedy),
          .commands = std::move(commands),
          .distorts = false};
}

MachineFinding red(const char* check, std::string found, std::string remedy, std::string commands) {
  return {.check = check,
          .verdict = MachineVerdict::kRed,
          .found = std::move(found),
          .remedy = std::move(remedy),
          .commands = std::move(commands),
          .distorts = false};
}

std::optional<std::string> boot_parameter(const SystemView& system, const std::string& name) {
  std::istringstream words(system.read("/proc/cmdline").value_or(""));
  std::optional<std::string> value;  // the last one counts, as for the kernel
  for (std::string word; words >> word;) {
    if (word == name) value = "";
    if (word.starts_with(name + "=")) value = word.substr(name.size() + 1);
  }
  return value;
}

bool contains(const std::vector<int>& cpus, int cpu) { return std::find(cpus.begin(), cpus.end(), cpu) != cpus.end(); }

std::string cpu_folder(int cpu) { return "/sys/devices/system/cpu/cpu" + std::to_string(cpu); }

}  // namespace tactus::doctor
