#include "rt/haptics/coupling/device_track.h"

namespace tactus::haptics {
namespace {

constexpr std::uint32_t kMaxTicks = 1u << 31;

}  // namespace

void DeviceTrack::note(const DeviceTarget& target, double period_s) noexcept {
  if (!target.engaged) {
    engaged_ticks = 0;
    return;
  }
  device = {target.pose.position + period_s * target.velocity.linear,
            quat_from_rotation_vector(period_s * target.velocity.angular) * target.pose.rotation};
  velocity = target.velocity;
  if (engaged_ticks < kMaxTicks) ++engaged_ticks;
}

DeviceTarget DeviceTrack::over_cycle(std::uint32_t ticks, double period_s) const noexcept {
  if (engaged_ticks == 0) return {};
  const bool whole_cycle = ticks > 0 && engaged_ticks > ticks;
  return {true, device, whole_cycle ? mean_velocity(before, device, ticks * period_s) : velocity};
}

}  // namespace tactus::haptics
