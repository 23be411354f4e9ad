#include <fmt/format.h>

#include <algorithm>

#include "hal/can/can_interface.h"
#include "tools/doctor/checks.h"

namespace tactus::doctor {
namespace {

constexpr const char* kVendor = "1209";
constexpr const char* kProduct = "0001";
const std::string kUsbDevices = "/sys/bus/usb/devices/";

// The device's folder below kUsbDevices, if it is plugged in.
std::optional<std::string> usb_device(const SystemView& system) {
  for (const std::string& name : system.list(kUsbDevices))
    if (system.read(kUsbDevices + name + "/idVendor") == kVendor &&
        system.read(kUsbDevices + name + "/idProduct") == kProduct)
      return name;
  return std::nullopt;
}

// Interrupt lines of a device in sysfs: its MSI lines, otherwise its wired line.
std::vector<std::string> lines_of(const SystemView& system, const std::string& folder) {
  std::vector<std::string> lines = system.list(folder + "/msi_irqs");
  const auto wire = system.read(folder + "/irq");
  if (lines.empty() && wire && *wire != "0") lines.push_back(*wire);
  return lines;
}

// Interrupt lines of a USB bus, from the parent of its root hub, the controller.
std::vector<std::string> lines_of_usb_bus(const SystemView& system, const std::string& bus) {
  return lines_of(system, kUsbDevices + "usb" + bus + "/..");
}

}  // namespace

MachineFinding check_usb(const CheckContext& context) {
  if (const auto name = usb_device(context.system)) {
    const auto number = [&](const char* file) {
      return std::atoi(context.system.read(kUsbDevices + *name + file).value_or("0").c_str());
    };
    const std::string node = fmt::format("/dev/bus/usb/{:03}/{:03}", number("/busnum"), number("/devnum"));
    if (context.system.writable(node))
      return green("usb", "a device is there, and this user may use it (" + node + ")");
    return red(
        "usb", node + " is a device that this user may not use", "add a udev rule for it and plug it in again",
        fmt::format("echo 'SUBSYSTEM==\"usb\", ATTR{{idVendor}}==\"{}\", ATTR{{idProduct}}==\"{}\", MODE=\"0660\", "
                    "TAG+=\"uaccess\"' > /etc/udev/rules.d/61-tactus-usb.rules && udevadm control --reload",
                    kVendor, kProduct));
  }
  return red("usb", fmt::format("no device {}:{} is plugged in", kVendor, kProduct),
             "plug it in and switch it on; lsusb shows what is there");
}

MachineFinding check_can(const CheckContext& context, const std::string& name) {
  if (!context.system.is_this_machine()) return amber("can", "not in a recorded tree", "ask on the machine itself");
  const auto interface = hal::find_can_interface(name);
  if (!interface.ok())
    return red("can", interface.message(), "load the controller's driver; ip link shows what is there");
  const hal::CanInterface& can = interface.value();
  const std::string up = fmt::format(
      "ip link set {0} down && ip link set {0} type can bitrate 1000000 restart-ms 100 && ip link set {0} up", name);
  if (can.is_can && can.controller == hal::CanInterface::Controller::kBusOff)
    return red("can", name + " is off the bus: too many errors",
               "check cable, terminators and bit rate, then set it down and up",
               fmt::format("ip link set {} down && ip link set {} up", name, name));
  const auto period = std::chrono::nanoseconds(static_cast<std::int64_t>(1e9 / context.request.rate_Hz));
  for (const Status& status : {hal::check_can_interface(can, can.fd), hal::check_can_rate(can, can.fd, period)})
    if (!status.ok()) return red("can", status.message(), "set the interface up with the bit rate of the device", up);
  return green("can", can.is_virtual ? name + " is up, a virtual bus"
                                     : fmt::format("{} is up at {} kbit/s; errors sent {}, received {}", name,
                                                   can.bit_per_s / 1000, can.tx_errors, can.rx_errors));
}

std::vector<std::string> bus_interrupt_lines(const CheckContext& context) {
  const SystemView& system = context.system;
  if (context.request.usb) {
    const auto name = usb_device(system);
    return name ? lines_of_usb_bus(system, system.read(kUsbDevices + *name + "/busnum").value_or("0"))
                : std::vector<std::string>{};
  }
  std::vector<std::string> lines;
  for (const std::string& interface : context.request.can_interfaces) {
    const std::string controller = "/sys/class/net/" + interface + "/device";
    // A USB adapter uses the interrupt of that bus's controller.
    const auto bus = system.read(controller + "/../busnum");
    for (std::string& line : bus ? lines_of_usb_bus(system, *bus) : lines_of(system, controller))
      if (std::find(lines.begin(), lines.end(), line) == lines.end()) lines.push_back(std::move(line));
  }
  return lines;
}

// Bound to one core, a frame's interrupt waits only for the loop; distributed over several cores, for their other work.
MachineFinding check_bus_interrupt(const CheckContext& context) {
  std::string where, commands;
  bool spread = false;
  for (const std::string& line : bus_interrupt_lines(context)) {
    const std::string file = "/proc/irq/" + line + "/smp_affinity_list";
    const auto list = context.system.read(file);
    const auto allowed = parse_cpu_list(list.value_or(""));
    if (!allowed || allowed->empty()) continue;
    where += fmt::format("{}interrupt {} may come to cpu {}", where.empty() ? "" : ", ", line, *list);
    if (allowed->size() == 1) continue;
    spread = true;
    commands += fmt::format("{}echo {} > {}", commands.empty() ? "" : "\n", context.cpu, file);
  }
  if (where.empty())
    return amber("bus-interrupt", "where the link's interrupt goes cannot be read", "see whether /proc is mounted");
  if (!spread) return green("bus-interrupt", "the link's " + where + " alone");
  return amber("bus-interrupt", "the link's " + where + ": a frame waits for what runs there",
               fmt::format("bind it to one core, best the loop's own, cpu {}, and switch irqbalance off", context.cpu),
               commands);
}

}  // namespace tactus::doctor
