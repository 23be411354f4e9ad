// Sine and cosine in float arithmetic only; the same bits on every machine without fused multiply-add.
//
// The argument is reduced to |r| <= pi/4 in three exact steps (pi/2 in pieces of 11 bits: multiples up to 2^13 are
// exact), then the Taylor polynomial is used, whose remainder is below 3e-8 there. Radians. Thread: [any]; pure.
// Bound: |x| <= 8192; beyond that, and for NaN, both are 0, so that an unreliable term has no effect.
#pragma once

#include <cstdint>

namespace tactus::firmware {

struct SineCosine {
  float sine{0.0f}, cosine{0.0f};
};

constexpr SineCosine sine_cosine(float x) noexcept {
  constexpr float kLargest = 8192.0f, kTwoOverPi = 0.63661977f;
  constexpr float kHigh = 1.5703125f, kMiddle = 4.837512969970703e-4f, kLow = 7.549789954891882e-8f;
  if (!(x >= -kLargest && x <= kLargest)) return {};
  const float turns = x * kTwoOverPi;
  const auto quarter = static_cast<std::int32_t>(turns < 0.0f ? turns - 0.5f : turns + 0.5f);
  const auto q = static_cast<float>(quarter);
  const float r = ((x - q * kHigh) - q * kMiddle) - q * kLow;
  const float r2 = r * r;
  const float s = r + r * r2 * (-1.0f / 6 + r2 * (1.0f / 120 + r2 * (-1.0f / 5040 + r2 * (1.0f / 362880))));
  const float c =
      1.0f + r2 * (-0.5f + r2 * (1.0f / 24 + r2 * (-1.0f / 720 + r2 * (1.0f / 40320 - r2 * (1.0f / 3628800)))));
  switch (static_cast<std::uint32_t>(quarter) & 3u) {
    case 0:
      return {s, c};
    case 1:
      return {c, -s};
    case 2:
      return {-s, -c};
    default:
      return {-c, s};
  }
}

}  // namespace tactus::firmware
