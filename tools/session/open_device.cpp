#include "tools/session/open_device.h"

#include <fmt/format.h>

#include <cmath>

#include "hal/device_record.h"
#include "hal/identity_check.h"
#include "tools/session/open_link.h"

namespace tactus::session {
namespace {

// Time limit for an answer. A device answers once a period; the rest is a margin for a busy machine.
constexpr std::chrono::milliseconds kAnswer{500};

std::int64_t period_ns(const RunOptions& options) { return std::llround(options.period_s() * 1e9); }

}  // namespace

Result<std::function<Status()>> remember_device(hal::AnyLink& link) {
  const auto record = hal::DeviceRecord::read(link, kAnswer);
  if (!record.ok()) return record.status();
  return std::function<Status()>([&link, began_with = record.value()] { return began_with.compare(link, kAnswer); });
}

Result<Hardware> open_hardware(const RunOptions& options, const hal::DeviceProfile& profile) {
  Hardware hardware;
  const auto choice = parse_device_choice(options.device);
  if (!choice.ok()) return choice.status();
  if (options.taped_device) return hardware;
  if (choice.value().is_real()) {
    auto opened = open_link(choice.value(), profile.description, period_ns(options));
    if (!opened.ok()) return opened.status();
    const auto period_us = static_cast<std::uint32_t>(period_ns(options) / 1000);
    const Status same = hal::check_identity(profile, period_us, *opened.value().link, kAnswer);
    if (!same.ok()) return Status::error(fmt::format("--device {}: {}", options.device, same.message()));
    auto same_device = remember_device(*opened.value().link);
    if (!same_device.ok()) return Status::error(fmt::format("--device {}: {}", options.device, same_device.message()));
    hardware.same_device = std::move(same_device).value();
    using Device = hal::DeviceOnLink<hal::AnyLink>;
    auto device = std::make_unique<Device>(profile, period_ns(options), std::move(opened.value().link));
    hardware.device = std::make_unique<hal::AnyDevice>(std::move(device));
    hardware.identity = std::move(opened.value().name);
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
  hal::SimulationOptions simulation;
  simulation.period_ns = period_ns(options);
  simulation.seed = options.seed;
  simulation.faults = faults;
  if (const Status status = hal::SimulatedDevice::check(simulation); !status.ok()) return status;
  return std::make_unique<hal::AnyDevice>(std::make_unique<hal::SimulatedDevice>(profile, hand, simulation));
}

}  // namespace tactus::session
