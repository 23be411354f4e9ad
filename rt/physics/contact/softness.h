// The compliance of a contact: an implicit spring and damper, given by frequency and damping ratio.
//
// Equal to implicit Euler of a spring k = m w^2 and damper c = 2 z m w on the row's effective mass m (w = 2 pi hertz,
// z: damping ratio). So a constant load F causes the overlap F / (m w^2). Stable and accurate for hertz <= 0.25 / h.
// Source: Catto, soft constraints. Thread: [any].
//
// Several contacts of the same two bodies (compounds touch by several parts) are springs in parallel. If they have as
// many points as n full contacts, each has k / n and c / n, so that together they are as stiff as one contact and as
// far from the bound above. In the formulas below a2 becomes a2 / n; bias_rate does not change. With k for each
// contact, stacks of eight compounds of two halves vibrated at 40 mm/s (2026-11-26).
//
// How many relax sweeps a stack needs to come to rest: Gauss-Seidel sweeps hardly correct the sway of a tall stack, so
// its impulses lag. A sweep adds -m u to an impulse; the biased sweep also adds -m b s and removes the share
// 1 / (1 + a2). Over many sub-steps that is a spring with an integral part and a leak. The sway decays while the leak
// 1 / (h^2 w^2) b exceeds the integral part b / (1 + sweeps): (w h)^2 < 1 + relax sweeps. So hertz < 0.225 / h with one
// relax sweep, 0.27 / h with two. Confirmed on heaps of 1,000 cubes at 10 ms: 10 sub-steps at 200 Hz come to rest
// (1e-15 m/s); at 250 Hz whole columns keep swaying at 5e-4 m/s, with two sweeps they do not (2026-11-22).
#pragma once

#include <cstdint>

#include "rt/base/wide.h"

namespace tactus::physics {

template <class T>
struct Softness {
  T bias_rate{};  // 1/s: velocity per metre of error
  T mass_scale{T(1)};
  T impulse_scale{};

  // `hertz` [Hz], `damping_ratio` [-], `h` sub-step [s].
  static constexpr Softness make(T hertz, T damping_ratio, T h) noexcept {
    const T omega = T(2) * T(3.14159265358979323846) * hertz;
    const T a1 = T(2) * damping_ratio + h * omega, a2 = added_inertia(hertz, damping_ratio, h), a3 = T(1) / (T(1) + a2);
    return {omega / a1, a2 * a3, a3};
  }
  // The inertia that spring and damper add in a step of `h` [s], in units of m: a2 = (h c + h^2 k) / m.
  static constexpr T added_inertia(T hertz, T damping_ratio, T h) noexcept {
    const T turn = T(2) * T(3.14159265358979323846) * hertz * h;
    return turn * (T(2) * damping_ratio + turn);
  }
  static constexpr Softness rigid() noexcept { return {}; }
};

// What the biased sweep of a contact adds to correct an overlap.
template <class V>
struct Correction {
  V push;  // m/s, at most 0
  V leak;  // N s: the share of the impulse that decays
};

// An overlap is corrected at `-least` [m/s] at most: if the push b is below `least`, it is limited to that speed, b',
// and the leak l to the larger of (b' / b) l and l - m (b' - b), `mass` m. So a load still sinks to F / (m w^2), an
// excess impulse decays as fast as without the limit, and only what opens the contact is slow. With the push alone
// limited the force ended at m a2 max_push_speed / h: 1000 : 1 sank in.
template <class V>
TACTUS_INLINE Correction<V> limited(Correction<V> of, V mass, V least) noexcept {
  if (const auto deep = of.push < least; any(deep)) {
    of.leak = select(deep, larger(of.leak * (least / of.push), of.leak + mass * (of.push - least)), of.leak);
    of.push = larger(of.push, least);
  }
  return of;
}

// Least number of relax sweeps per sub-step of `h` [s] with which stacks come to rest.
template <class T>
constexpr std::uint32_t least_relax_sweeps(T hertz, T h) noexcept {
  return hertz * h > T(0.2) * (T(1) + T(1e-6)) ? 2 : 1;
}

}  // namespace tactus::physics
