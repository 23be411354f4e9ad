#include "tools/session/open_device.h"

#include <fmt/format.h>

#include <cmath>

namespace tactus::session {
namespace {

Result<OpenedDevice> open_simulated(const RunOptions& options, const hal::DeviceProfile& profile,
                                    const hal::HandModel& hand, const hal::FaultScript& faults) {
  hal::SimulationOptions simulation;
  simulation.period_ns = std::llround(options.period_s() * 1e9);
  simulation.seed = options.seed;
  simulation.faults = faults;
  if (const Status status = hal::SimulatedDevice::check(simulation); !status.ok()) return status;
  auto device = std::make_unique<hal::SimulatedDevice>(profile, hand, simulation);
  return OpenedDevice{std::make_unique<hal::AnyDevice>(std::move(device)), ""};
}

}  // namespace

Result<OpenedDevice> open_device(const RunOptions& options, const std::string& profile_name, const hal::HandModel& hand,
                                 const hal::FaultScript& faults) {
  if (options.taped_device)
    return OpenedDevice{std::make_unique<hal::AnyDevice>(std::make_unique<TapedDevice>(*options.taped_device)), ""};
  const auto choice = parse_device_choice(options.device);
  if (!choice.ok()) return choice.status();
  const hal::DeviceProfile* profile = hal::find_profile(profile_name);
  if (profile == nullptr) return Status::error(fmt::format("no device profile '{}'", profile_name));
  if (!choice.value().is_real()) return open_simulated(options, *profile, hand, faults);
  return Status::error(fmt::format("--device: '{}' is no device of this build; accepted: sim", options.device));
}

}  // namespace tactus::session
