#include <fmt/format.h>

#include "tools/doctor/checks.h"

namespace tactus::doctor {
namespace {

constexpr std::uint64_t kPriority = 80;  // priority that the loop requests

std::string limits_file(const ProcessFacts& process, const char* line) {
  return fmt::format("echo '{} - {}' >> /etc/security/limits.d/60-tactus.conf   # then log in again", process.user,
                     line);
}

}  // namespace

MachineFinding check_priority_limit(const CheckContext& context) {
  const ProcessFacts& process = context.system.process();
  if (process.may_set_priority) return green("priority-limit", "this process may ask for any real-time priority");
  if (process.rtprio_limit >= kPriority)
    return green("priority-limit", fmt::format("real-time priorities up to {}", process.rtprio_limit));
  return red("priority-limit",
             fmt::format("{} may ask for real-time priorities up to {}, the loop wants {}", process.user,
                         process.rtprio_limit, kPriority),
             "set rtprio 98 for this user in /etc/security/limits.d, or give the program CAP_SYS_NICE",
             limits_file(process, "rtprio 98"));
}

MachineFinding check_memory_limit(const CheckContext& context) {
  const ProcessFacts& process = context.system.process();
  if (process.may_lock_memory || process.memlock_limit_B == ~std::uint64_t{0})
    return green("memory-limit", "this process may lock all its memory");
  return red(
      "memory-limit",
      fmt::format("{} may lock {} KiB: the loop will meet page faults", process.user, process.memlock_limit_B / 1024),
      "set memlock unlimited for this user in /etc/security/limits.d, or give the program CAP_IPC_LOCK",
      limits_file(process, "memlock unlimited"));
}

MachineFinding check_gpio(const CheckContext& context) {
  std::string chips;
  for (const std::string& name : context.system.list("/dev")) {
    if (!name.starts_with("gpiochip")) continue;
    if (context.system.writable("/dev/" + name))
      return green("gpio", "/dev/" + name + " is there, and this user may use it");
    chips = name;
  }
  if (chips.empty()) return red("gpio", "there is no /dev/gpiochip*", "load the driver of your GPIO hardware");
  return red("gpio", "/dev/" + chips + " is there, and this user may not use it",
             "join the group gpio, or add a udev rule",
             "echo 'SUBSYSTEM==\"gpio\", MODE=\"0660\", TAG+=\"uaccess\"' > /etc/udev/rules.d/60-tactus-gpio.rules && "
             "udevadm control --reload");
}

}  // namespace tactus::doctor
