#include "rt/haptics/interpolation_coupling.h"

namespace tactus::haptics {
namespace {

constexpr std::uint32_t kMostTicks = 1u << 31;

// From a (share 0) to b (share 1) the short way round. The chord and not the arc: it ends on b exactly, and the turn of
// one cycle is so small that its speed is even to a share of turn^2 / 8.
Quatd between(const Quatd& a, const Quatd& b, double share) noexcept {
  const double way = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z < 0 ? -share : share;
  const double rest = 1.0 - share;
  return normalized(
      Quatd{rest * a.w + way * b.w, rest * a.x + way * b.x, rest * a.y + way * b.y, rest * a.z + way * b.z});
}

Twistd mean_velocity(const Posed& from, const Posed& to, double time_s) noexcept {
  return {(to.position - from.position) * (1 / time_s),
          small_rotation_vector(to.rotation * conjugate(from.rotation)) * (1 / time_s)};
}

}  // namespace

void InterpolationCoupling::adopt(const physics::BodyMotion& proxy, bool first) noexcept {
  global_proxy[0] = first ? proxy : global_proxy[1];
  global_proxy[1] = proxy;
  device_before = device;
}

DeviceTarget InterpolationCoupling::report(std::uint32_t ticks, double period_s) const noexcept {
  if (engaged_ticks == 0) return {};
  const bool whole_cycle = ticks > 0 && engaged_ticks > ticks;
  return {true, device, whole_cycle ? mean_velocity(device_before, device, ticks * period_s) : device_velocity};
}

physics::BodyMotion InterpolationCoupling::proxy_in(std::uint32_t tick, std::uint32_t ratio,
                                                    double period_s) const noexcept {
  const Posed &from = global_proxy[0].pose, &to = global_proxy[1].pose;
  const bool late = tick >= ratio;
  const double share = late ? 1.0 : static_cast<double>(tick + 1) / ratio;
  const Posed pose{from.position + share * (to.position - from.position), between(from.rotation, to.rotation, share)};
  return {pose, late ? Twistd{} : mean_velocity(from, to, ratio * period_s)};
}

void InterpolationCoupling::note(const DeviceTarget& target, double period_s) noexcept {
  if (!target.engaged) {
    engaged_ticks = 0;
    return;
  }
  device = {target.pose.position + period_s * target.velocity.linear,
            quat_from_rotation_vector(period_s * target.velocity.angular) * target.pose.rotation};
  device_velocity = target.velocity;
  if (engaged_ticks < kMostTicks) ++engaged_ticks;
}

}  // namespace tactus::haptics
