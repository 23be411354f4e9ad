#include <fmt/format.h>

#include "hal/can/can_interface.h"
#include "tools/doctor/checks.h"

namespace tactus::doctor {
namespace {

constexpr std::uint64_t kPriority = 80;  // what the loop asks for
constexpr const char* kVendor = "1209";
constexpr const char* kProduct = "0001";

std::string limits_file(const ProcessFacts& process, const char* line) {
  return fmt::format("echo '{} - {}' >> /etc/security/limits.d/60-tactus.conf   # then log in again", process.user,
                     line);
}

}  // namespace

Finding check_priority_limit(const Patient& patient) {
  const ProcessFacts& process = patient.system.process();
  if (process.may_set_priority) return green("priority-limit", "this process may ask for any real-time priority");
  if (process.rtprio_limit >= kPriority)
    return green("priority-limit", fmt::format("real-time priorities up to {}", process.rtprio_limit));
  return red("priority-limit",
             fmt::format("{} may ask for real-time priorities up to {}, the loop wants {}", process.user,
                         process.rtprio_limit, kPriority),
             "set rtprio 98 for this user in /etc/security/limits.d, or give the program CAP_SYS_NICE",
             limits_file(process, "rtprio 98"));
}

Finding check_memory_limit(const Patient& patient) {
  const ProcessFacts& process = patient.system.process();
  if (process.may_lock_memory || process.memlock_limit_B == ~std::uint64_t{0})
    return green("memory-limit", "this process may lock all its memory");
  return red(
      "memory-limit",
      fmt::format("{} may lock {} KiB: the loop will meet page faults", process.user, process.memlock_limit_B / 1024),
      "set memlock unlimited for this user in /etc/security/limits.d, or give the program CAP_IPC_LOCK",
      limits_file(process, "memlock unlimited"));
}

Finding check_usb(const Patient& patient) {
  const std::string folder = "/sys/bus/usb/devices/";
  for (const std::string& name : patient.system.list(folder)) {
    if (patient.system.read(folder + name + "/idVendor") != kVendor ||
        patient.system.read(folder + name + "/idProduct") != kProduct)
      continue;
    const auto number = [&](const char* file) {
      return std::atoi(patient.system.read(folder + name + file).value_or("0").c_str());
    };
    const std::string node = fmt::format("/dev/bus/usb/{:03}/{:03}", number("/busnum"), number("/devnum"));
    if (patient.system.writable(node))
      return green("usb", "a device is there, and this user may use it (" + node + ")");
    return red(
        "usb", node + " is a device that this user may not use", "add a udev rule for it and plug it in again",
        fmt::format("echo 'SUBSYSTEM==\"usb\", ATTR{{idVendor}}==\"{}\", ATTR{{idProduct}}==\"{}\", MODE=\"0660\", "
                    "TAG+=\"uaccess\"' > /etc/udev/rules.d/60-tactus.rules && udevadm control --reload",
                    kVendor, kProduct));
  }
  return red("usb", fmt::format("no device {}:{} is plugged in", kVendor, kProduct),
             "plug it in and switch it on; lsusb shows what is there");
}

Finding check_gpio(const Patient& patient) {
  std::string chips;
  for (const std::string& name : patient.system.list("/dev")) {
    if (!name.starts_with("gpiochip")) continue;
    if (patient.system.writable("/dev/" + name))
      return green("gpio", "/dev/" + name + " is there, and this user may use it");
    chips = name;
  }
  if (chips.empty()) return red("gpio", "there is no /dev/gpiochip*", "load the driver of your GPIO hardware");
  return red("gpio", "/dev/" + chips + " is there, and this user may not use it",
             "join the group gpio, or add a udev rule",
             "echo 'SUBSYSTEM==\"gpio\", MODE=\"0660\", TAG+=\"uaccess\"' > /etc/udev/rules.d/60-tactus-gpio.rules && "
             "udevadm control --reload");
}

Finding check_can(const Patient& patient) {
  if (!patient.system.is_this_machine()) return amber("can", "not in a recorded tree", "ask on the machine itself");
  const std::string& name = patient.request.can_interface;
  const auto interface = hal::find_can_interface(name);
  if (!interface.ok())
    return red("can", interface.message(), "load the controller's driver; ip link shows what is there");
  const hal::CanInterface& can = interface.value();
  const std::string up =
      fmt::format("ip link set {} type can bitrate 1000000 restart-ms 100 && ip link set {} up", name, name);
  if (can.is_can && can.controller == hal::CanInterface::Controller::kBusOff)
    return red("can", name + " is off the bus: too many errors",
               "check cable, terminators and bit rate, then set it down and up",
               fmt::format("ip link set {} down && ip link set {} up", name, name));
  const auto period = std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / patient.request.rate_Hz));
  for (const Status& status : {hal::check_can_interface(can, can.fd), hal::check_can_rate(can, can.fd, period)})
    if (!status.ok()) return red("can", status.message(), "set the interface up with the bit rate of the device", up);
  return green("can", can.is_virtual ? name + " is up, a virtual bus"
                                     : fmt::format("{} is up at {} kbit/s; errors sent {}, received {}", name,
                                                   can.bit_per_s / 1000, can.tx_errors, can.rx_errors));
}

}  // namespace tactus::doctor
