#include "tools/session/open_device.h"

#include <fmt/format.h>

#include <cmath>
#include <span>

#include "sim/model/scene.h"

namespace tactus::session {
namespace {

Result<hal::OpenedDevice> open(const RunOptions& options, const hal::DeviceProfile& profile, const hal::HandModel& hand,
                               const hal::FaultScript& faults) {
  const auto choice = hal::choose_device(options.device);
  if (!choice.ok()) return choice.status();
  return choice.value().device_class->open({.address = choice.value().address,
                                            .profile = profile,
                                            .period_ns = std::llround(options.period_s() * 1e9),
                                            .hand = hand,
                                            .faults = faults,
                                            .seed = options.seed});
}

// Names the option, where the class has not.
Status of_option(const RunOptions& options, const Status& status) {
  if (status.message().starts_with("--device")) return status;
  return Status::error(fmt::format("--device {}: {}", options.device, status.message()));
}

}  // namespace

static Result<Hardware> open_real(const RunOptions& options, const hal::DeviceProfile& profile) {
  Hardware hardware;
  const auto choice = hal::choose_device(options.device);
  if (!choice.ok()) return choice.status();
  if (options.taped_device || !choice.value().device_class->real) return hardware;
  auto opened = open(options, profile, {}, {});
  if (!opened.ok()) return of_option(options, opened.status());
  hardware.real = true;
  hardware.device = std::move(opened.value().device);
  hardware.identity = std::move(opened.value().identity);
  hardware.same_device = std::move(opened.value().same_device);
  return hardware;
}

static Status open_lines(const std::string& gpio, std::span<Hardware> hands) {
  if (gpio.empty()) return Status::good();
  const auto options = hal::parse_gpio_options(gpio);
  if (!options.ok()) return options.status();
  auto lines = hal::GpioLines::open(options.value());
  if (!lines.ok()) return Status::error("--gpio: " + lines.message());
  static_assert(sim::kMaxHands <= hal::HandLines::kMaxHands);
  auto shared = hal::HandLines::share(std::move(lines).value(), static_cast<unsigned>(hands.size()));
  for (std::size_t hand = 0; hand < hands.size(); ++hand) hands[hand].gpio = std::move(shared[hand]);
  return Status::good();
}

Result<Hardware> open_hardware(const RunOptions& options, const hal::DeviceProfile& profile) {
  auto hardware = open_real(options, profile);
  if (!hardware.ok() || options.taped_device) return hardware;
  if (const Status status = open_lines(options.gpio, {&hardware.value(), 1}); !status.ok()) return status;
  return hardware;
}

Result<std::vector<Hardware>> open_hardware(const std::vector<RunOptions>& options,
                                            const std::vector<hal::DeviceProfile>& profiles, const std::string& gpio) {
  std::vector<Hardware> hands;
  for (std::size_t hand = 0; hand < options.size(); ++hand) {
    auto opened = open_real(options[hand], profiles[hand]);
    if (!opened.ok()) return Status::error(fmt::format("hand {}: {}", hand + 1, opened.message()));
    hands.push_back(std::move(opened).value());
  }
  if (const Status status = open_lines(gpio, hands); !status.ok()) return status;
  return hands;
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
