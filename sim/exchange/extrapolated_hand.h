// The hand over the next cycle, as the global step and the prediction of the sub-world (sub_world_prediction.h) see it:
// extrapolated from the device's state in the reports that begin this cycle and the last two. What the hand does
// otherwise reaches outside bodies a cycle later (rt/haptics/coupling/border_correction.h).
//
// It goes on with its velocity v and, if it is steady, with its acceleration a:
//   pose(t) = x + v t + a t^2 / 2,  velocity(t) = v + a t
// a is the change of v over the last cycle divided by its length. It is steady if
//   |a - a'| <= kSteady max(|a|, |a'|)
// with a' that of the cycle before: a push or a swing is, an impact, a tremor and noise of the velocity are not. Where
// a hand swings with the angular frequency w, and a cycle takes T, |a - a'| is 2 sin(w T / 2) |a|. Over a cycle its
// velocity alone is off by (w T)^2 / 2 of the swing, with a by 5 / 12 (w T)^3 (a is that of half a cycle ago). So a is
// the better choice up to w T = 1.2, where kSteady would be 1.1.
// Thread: [any], pure. Frame: world. Units: SI.
#pragma once

#include "rt/haptics/coupling/snapshot.h"

namespace tactus::sim {

// Measured range: 0.25 to 1 (tests/border/README.md).
inline constexpr double kSteady = 0.5;

struct ExtrapolatedHand {
  haptics::DeviceTarget now{};  // as the cycle begins
  Twistd rate{};                // m/s^2, rad/s^2: mean acceleration over the last cycle; 0 if the hand was not engaged
  Twistd acceleration{};        // m/s^2, rad/s^2: `rate` if it is steady, else 0

  // `device`: as the next cycle begins; `last_cycle_s`: length of the cycle that ended, 0 if there was none.
  void take(const haptics::DeviceTarget& device, double last_cycle_s) noexcept {
    const Twistd before = rate;
    const bool known = now.engaged && device.engaged && last_cycle_s > 0.0;
    rate = known ? (device.velocity - now.velocity) * (1.0 / last_cycle_s) : Twistd{};
    acceleration = {steady(before.linear, rate.linear), steady(before.angular, rate.angular)};
    now = device;
  }

  // The device `time_s` after the cycle began.
  haptics::DeviceTarget after(double time_s) const noexcept {
    haptics::DeviceTarget then = now;
    if (!now.engaged) return then;
    const Twistd mean = now.velocity + acceleration * (0.5 * time_s);
    then.pose = {now.pose.position + time_s * mean.linear,
                 quat_from_rotation_vector(time_s * mean.angular) * now.pose.rotation};
    then.velocity = velocity_after(time_s);
    return then;
  }
  Twistd velocity_after(double time_s) const noexcept { return now.velocity + acceleration * time_s; }

 private:
  static Vec3d steady(const Vec3d& before, const Vec3d& now) noexcept {
    const double larger_squared = larger(norm_squared(before), norm_squared(now));
    return norm_squared(now - before) <= kSteady * kSteady * larger_squared ? now : Vec3d{};
  }
};

}  // namespace tactus::sim
