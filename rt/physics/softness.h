// A contact as an implicit spring and damper, by frequency and damping ratio.
//
// Exactly implicit Euler of a spring k = m w^2 and damper c = 2 z m w of the row's effective mass m, so a load F sinks
// F / (m w^2) deep. Source: Catto, soft constraints. Stable and accurate for hertz <= 0.25 / h. Thread: [any].
#pragma once

namespace tactus::physics {

template <class T>
struct Softness {
  T bias_rate{};  // 1/s: velocity per metre of error
  T mass_scale{T(1)};
  T impulse_scale{};

  // `hertz` [Hz], `damping_ratio` [-], `h` sub-step [s].
  static constexpr Softness make(T hertz, T damping_ratio, T h) noexcept {
    const T omega = T(2) * T(3.14159265358979323846) * hertz;
    const T a1 = T(2) * damping_ratio + h * omega, a2 = h * omega * a1, a3 = T(1) / (T(1) + a2);
    return {omega / a1, a2 * a3, a3};
  }
  static constexpr Softness rigid() noexcept { return {}; }
};

}  // namespace tactus::physics
