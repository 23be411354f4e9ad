#include "hal/classes/on_link.h"

#include "hal/device_record.h"
#include "hal/identity_check.h"

namespace tactus::hal {
namespace {

// Time limit for an answer. A device answers once a period; the rest is a margin for a busy machine.
constexpr std::chrono::milliseconds kAnswer{500};

}  // namespace

Result<std::function<Status()>> remember_device(AnyLink& link) {
  const auto record = DeviceRecord::read(link, kAnswer);
  if (!record.ok()) return record.status();
  return std::function<Status()>([&link, began_with = record.value()] { return began_with.compare(link, kAnswer); });
}

Result<OpenedDevice> open_on_link(OpenedLink opened, const DeviceRequest& request) {
  const auto period_us = static_cast<std::uint32_t>(request.period_ns / 1000);
  if (const Status same = check_identity(request.profile, period_us, *opened.link, kAnswer); !same.ok()) return same;
  auto same_device = remember_device(*opened.link);
  if (!same_device.ok()) return same_device.status();
  using Device = DeviceOnLink<AnyLink>;
  auto device = std::make_unique<Device>(request.profile, request.period_ns, std::move(opened.link));
  return OpenedDevice{std::make_unique<AnyDevice>(std::move(device)), std::move(opened.name),
                      std::move(same_device).value()};
}

}  // namespace tactus::hal
