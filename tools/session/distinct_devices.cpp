#include "tools/session/distinct_devices.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <vector>

#include "hal/device_class.h"
#include "tools/session/find_description.h"

namespace tactus::session {
namespace {

struct Taken {
  const hal::DeviceClass* by{nullptr};
  std::vector<std::string> what;
};

// Returns what the device occupies; empty for a simulated device and an unknown name.
std::optional<Taken> taken_by(const NamedDevice& named, const std::string& profile_name) {
  const auto choice = hal::choose_device(named.device);
  if (!choice.ok() || choice.value().device_class->takes == nullptr) return std::nullopt;
  const auto profile = find_description(profile_name, named.file);
  const hal::DeviceDescription description = profile.ok() ? profile.value().description : hal::DeviceDescription{};
  const hal::DeviceClass* by = choice.value().device_class;
  return Taken{by, by->takes(choice.value().address, description)};
}

// Returns the shared resource. An empty name matches every device of the class.
std::optional<std::string> common(const Taken& a, const Taken& b) {
  if (a.by != b.by) return std::nullopt;
  for (const std::string& one : a.what)
    for (const std::string& other : b.what)
      if (one.empty() || other.empty() || one == other) return one.empty() ? other : one;
  return std::nullopt;
}

}  // namespace

Status check_distinct(std::span<const NamedDevice> devices, const std::string& profile_name) {
  std::vector<std::optional<Taken>> taken;
  for (std::size_t hand = 0; hand < devices.size(); ++hand) {
    taken.push_back(taken_by(devices[hand], profile_name));
    for (std::size_t other = 0; taken[hand] && other < hand; ++other) {
      if (!taken[other]) continue;
      const auto both = common(*taken[hand], *taken[other]);
      if (!both) continue;
      return Status::error(fmt::format(
          "--device {}: serves one hand, and this is of two: {} of hand {} takes {}, too; accepted: each its own, {}",
          devices[hand].device, devices[other].device, other + 1, both->empty() ? "the first one there is" : *both,
          taken[hand]->by->each_its_own));
    }
  }
  return Status::good();
}

}  // namespace tactus::session
