// Motor efforts that carry the arm's own weight, as a function of the axis coordinates.
//
//   effort_i = constant_i + sum over k = 0..3 of amplitude_ik f_ik(n_ik . q),   f: sine or cosine, n: six integers
//
// q: the axes' coordinates [m, rad]. The gravity load of any chain of rigid links has this form in the joint angles:
// each link adds one term per axis below it. The integers, -8 to 7, form sums and differences of angles.
// Thread: [rt], pure. Bound: 24 terms; a term of amplitude 0 costs a comparison. Neutral by default.
#pragma once

#include "firmware/controller.h"

namespace tactus::firmware {

inline constexpr unsigned kGravityTerms = 4;  // per axis

struct GravityConfig {
  AxisValues constant{};                                 // N, N m
  std::array<float, kAxes * kGravityTerms> amplitude{};  // N, N m; term k of axis i at 4 i + k
  // Bits 4 j to 4 j + 3: the integer of axis j, two's complement; bit 24: cosine instead of sine.
  std::array<std::uint32_t, kAxes * kGravityTerms> combination{};
  std::uint32_t in_idle{0};  // 1: acts in IDLE too, also without a host
  friend constexpr bool operator==(const GravityConfig&, const GravityConfig&) noexcept = default;
};

inline constexpr std::uint32_t kCosineTerm = 1u << 24, kMaxCombination = (1u << 25) - 1;

// The integer of `axis`, -8 to 7.
constexpr std::int32_t combination_factor(std::uint32_t combination, unsigned axis) noexcept {
  const auto nibble = static_cast<std::int32_t>((combination >> (4 * axis)) & 0xfu);
  return nibble < 8 ? nibble : nibble - 16;
}

constexpr std::uint32_t make_combination(const std::array<std::int32_t, kAxes>& factors, bool cosine) noexcept {
  std::uint32_t combination = cosine ? kCosineTerm : 0u;
  for (unsigned axis = 0; axis < kAxes; ++axis)
    combination |= (static_cast<std::uint32_t>(factors[axis]) & 0xfu) << (4 * axis);
  return combination;
}

AxisValues gravity_effort(const GravityConfig& config, const AxisValues& coordinates) noexcept;

}  // namespace tactus::firmware
