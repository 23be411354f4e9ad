// Low-pass filter of the axis speeds, for damping and display. Overspeed is detected without it, in the same period.
//
// First order on the differences of successive readings: v += s (difference - v), s = w / (1 + w), w = 2 pi f T.
// Latency: half a period of the difference, plus the filter's 1 / (2 pi f). Units: as AxisSpeed. Thread: [rt], pure.
// Bound: never above the largest input. Corner frequency 0 (the default): no filter.
#pragma once

#include "firmware/controller.h"

namespace tactus::firmware {

class SpeedFilter {
 public:
  void update(const AxisValues& difference, float corner_Hz, std::uint32_t period_us) noexcept {
    const float w = 6.2831853f * corner_Hz * 1e-6f * static_cast<float>(period_us);
    const float share = corner_Hz > 0.0f ? w / (1.0f + w) : 1.0f;
    for (unsigned i = 0; i < kAxes; ++i)
      speed_[i] = share == 1.0f ? difference[i] : speed_[i] + share * (difference[i] - speed_[i]);
  }
  const AxisValues& speed() const noexcept { return speed_; }

 private:
  AxisValues speed_{};
};

}  // namespace tactus::firmware
