// Encoder counts: conversion between counts and axis coordinates, and axis speeds.
//
// Units: a quantum is metres or radians per count. Thread: [any]; pure functions, except AxisSpeed, which the control
// period owns. Bound: counts saturate at +-2^30; a difference wraps with the 32-bit counter and is correct below 2^31
// counts per period. No library mathematics: this file also compiles for a microcontroller.
#pragma once

#include <array>
#include <cstdint>

namespace tactus::firmware {

inline constexpr unsigned kAxes = 6;
inline constexpr std::int32_t kMaxCount = 1 << 30;

using AxisCounts = std::array<std::int32_t, kAxes>;

// Rounds to the nearest count, halves upwards. NaN gives 0.
template <class T>
constexpr std::int32_t count_of(T coordinate, T quantum) noexcept {
  const T scaled = coordinate / quantum + T(0.5);
  if (!(scaled > -static_cast<T>(kMaxCount))) return scaled == scaled ? -kMaxCount : 0;
  if (!(scaled < static_cast<T>(kMaxCount))) return kMaxCount;
  const auto towards_zero = static_cast<std::int32_t>(scaled);
  return static_cast<T>(towards_zero) > scaled ? towards_zero - 1 : towards_zero;
}

template <class T>
constexpr T coordinate_of(std::int32_t count, T quantum) noexcept {
  return static_cast<T>(count) * quantum;
}

// to - from, modulo the counter's wrap.
constexpr std::int32_t count_difference(std::int32_t to, std::int32_t from) noexcept {
  return static_cast<std::int32_t>(static_cast<std::uint32_t>(to) - static_cast<std::uint32_t>(from));
}

// Speeds of all axes from two successive readings.
class AxisSpeed {
 public:
  // Per axis, m/s or rad/s. The first call has no previous reading and returns zero. If the clock advanced by less than
  // half the nominal period, the nominal period is used: otherwise a single quantum would appear as a high speed.
  std::array<float, kAxes> update(const AxisCounts& counts, std::uint64_t time_us, std::uint32_t period_us,
                                  const std::array<float, kAxes>& quantum) noexcept {
    std::array<float, kAxes> speed{};
    if (known_) {
      const std::uint64_t elapsed_us = time_us - time_us_;
      const bool believable = time_us > time_us_ && elapsed_us >= period_us / 2;
      const float elapsed_s = static_cast<float>(believable ? elapsed_us : period_us) * 1e-6f;
      for (unsigned i = 0; i < kAxes; ++i)
        speed[i] = static_cast<float>(count_difference(counts[i], counts_[i])) * quantum[i] / elapsed_s;
    }
    counts_ = counts;
    time_us_ = time_us;
    known_ = true;
    return speed;
  }

  // Call when direction or offset of the counts changed, with the last reading after the change: causes no speed.
  void rebase(const AxisCounts& counts) noexcept { counts_ = counts; }

 private:
  AxisCounts counts_{};
  std::uint64_t time_us_{0};
  bool known_{false};
};

}  // namespace tactus::firmware
