#include "tools/session/open_device.h"

#include <fmt/format.h>

#include <cmath>

namespace tactus::session {
namespace {

Result<hal::OpenedDevice> open(const RunOptions& options, const hal::DeviceProfile& profile, const hal::HandModel& hand,
                               const hal::FaultScript& faults) {
  const auto choice = hal::choose_device(options.device);
  if (!choice.ok()) return choice.status();
  return choice.value().device_class->open(
      {choice.value().address, profile, std::llround(options.period_s() * 1e9), hand, faults, options.seed});
}

// Names the option, where the class has not.
Status of_option(const RunOptions& options, const Status& status) {
  if (status.message().starts_with("--device")) return status;
  return Status::error(fmt::format("--device {}: {}", options.device, status.message()));
}

}  // namespace

Result<Hardware> open_hardware(const RunOptions& options, const hal::DeviceProfile& profile) {
  Hardware hardware;
  const auto choice = hal::choose_device(options.device);
  if (!choice.ok()) return choice.status();
  if (options.taped_device) return hardware;
  if (choice.value().device_class->real) {
    auto opened = open(options, profile, {}, {});
    if (!opened.ok()) return of_option(options, opened.status());
    hardware.real = true;
    hardware.device = std::move(opened.value().device);
    hardware.identity = std::move(opened.value().identity);
    hardware.same_device = std::move(opened.value().same_device);
  }
  if (!options.gpio.empty()) {
    const auto lines = hal::parse_gpio_options(options.gpio);
    if (!lines.ok()) return lines.status();
    auto gpio = hal::GpioLines::open(lines.value());
    if (!gpio.ok()) return Status::error("--gpio: " + gpio.message());
    hardware.gpio = std::move(gpio).value();
  }
  return hardware;
}

Result<std::unique_ptr<hal::AnyDevice>> make_simulated(const RunOptions& options, const hal::DeviceProfile& profile,
                                                       const hal::HandModel& hand, const hal::FaultScript& faults) {
  if (options.taped_device)
    return std::make_unique<hal::AnyDevice>(std::make_unique<TapedDevice>(*options.taped_device));
  auto opened = open(options, profile, hand, faults);
  if (!opened.ok()) return of_option(options, opened.status());
  return std::move(opened.value().device);
}

}  // namespace tactus::session
