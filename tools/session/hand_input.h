// Passes a person's commands for the simulated hand from the control socket's thread to the thread that ticks.
//
// Without a command for kSilence_s the hand stays where it is. The time is counted in ticks, so that no tick depends on
// measured time.
// Frame: world. Units: SI. Thread: take, lead, rest: one, normal; apply: [rt] the one that ticks. Bound: constant work.
#pragma once

#include <cstdint>

#include "hal/simulated_device.h"
#include "rt/base/latest_value.h"

namespace tactus::session {

inline constexpr double kSilence_s = 0.2;

class HandInput {
 public:
  // The hand is the person's from the next lead() on, where it then is.
  void take() noexcept { ++take_; }
  // To this far from where it was taken [m; rotation vector, rad].
  void lead(const Vec3d& moved, const Vec3d& turned) noexcept {
    send({.take = take_, .leads = 1, .moved = moved, .turned = turned});
  }
  // It rests where it is, until it is taken again or the scene is reset.
  void rest() noexcept { send({.take = take_, .leads = 0, .moved = {}, .turned = {}}); }

  // Before each tick. `world_from_device`, `motion_scale`: as the scene places the device.
  void apply(hal::SimulatedDevice& device, const Posed& world_from_device, double motion_scale) noexcept {
    const Wish* const wish = newest_.take();
    if (wish == nullptr) {
      const auto silence =
          static_cast<std::uint64_t>(kSilence_s * 1e9) / static_cast<std::uint64_t>(device.period_ns());
      if (leading_ && ++silent_ticks_ == silence) device.hold_hand();
      return;
    }
    silent_ticks_ = 0;
    leading_ = wish->leads != 0;
    if (!leading_) return device.hold_hand();
    if (wish->take != taken_ || !device.hand_is_operated()) device.take_hand();
    taken_ = wish->take;
    const Quatd to_device = conjugate(world_from_device.rotation);
    device.lead_hand((1.0 / motion_scale) * rotate(to_device, wish->moved), rotate(to_device, wish->turned));
  }

 private:
  struct Wish {
    std::uint32_t take{0}, leads{0};
    Vec3d moved, turned;
  };
  void send(const Wish& wish) noexcept {
    newest_.writing() = wish;
    (void)newest_.publish();
  }

  LatestValue<Wish> newest_;
  std::uint32_t take_{0};
  // Of the thread that ticks.
  std::uint32_t taken_{0};
  bool leading_{false};
  std::uint64_t silent_ticks_{0};
};

}  // namespace tactus::session
