#include "rt/haptics/coupling/proxy_interpolation.h"

#include "rt/haptics/coupling/device_track.h"

namespace tactus::haptics {
namespace {

// Normalised linear interpolation (nlerp) from a (share 0) to b (share 1) by the shorter way. Not slerp: nlerp ends on
// b exactly, and over the small turn of one cycle its angular speed is constant to a relative turn^2 / 8.
Quatd between(const Quatd& a, const Quatd& b, double share) noexcept {
  const double way = a.w * b.w + a.x * b.x + a.y * b.y + a.z * b.z < 0 ? -share : share;
  const double rest = 1.0 - share;
  return normalized(
      Quatd{rest * a.w + way * b.w, rest * a.x + way * b.x, rest * a.y + way * b.y, rest * a.z + way * b.z});
}

}  // namespace

physics::BodyMotion ProxyInterpolation::in_tick(std::uint32_t tick, std::uint32_t ratio,
                                                double period_s) const noexcept {
  const Posed &from = global_proxy[0].pose, &to = global_proxy[1].pose;
  const bool late = tick >= ratio;
  const double share = late ? 1.0 : static_cast<double>(tick + 1) / ratio;
  const Posed pose{from.position + share * (to.position - from.position), between(from.rotation, to.rotation, share)};
  return {pose, late ? Twistd{} : mean_velocity(from, to, ratio * period_s)};
}

}  // namespace tactus::haptics
