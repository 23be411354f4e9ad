// Identifiers that are constant over a run. Thread: [any].
#pragma once

#include <compare>
#include <cstdint>

namespace tactus {

// Index of a body in its scene: dense, from 0, in the order of the scene file, which also orders slots, pairs and ties.
using BodyId = std::uint32_t;
inline constexpr BodyId kNoBody = 0xffffffffu;
inline constexpr BodyId kMaxBodyId = 0x7ffffffeu;  // 31 bits, so that two ids and a flag share one 64-bit key

// Key of a pair of bodies that may touch. Pairs with a fixed body sort after all others, so that a sweep ends with
// them.
struct PairKey {
  std::uint64_t value{0};

  static constexpr PairKey of(BodyId a, BodyId b, bool with_fixed) noexcept {
    const BodyId low = a < b ? a : b, high = a < b ? b : a;
    return {(with_fixed ? 1ull << 63 : 0ull) | (static_cast<std::uint64_t>(low) << 31) | high};
  }
  constexpr bool with_fixed() const noexcept { return (value >> 63) != 0; }
  constexpr BodyId low() const noexcept { return static_cast<BodyId>((value >> 31) & 0x7fffffffu); }
  constexpr BodyId high() const noexcept { return static_cast<BodyId>(value & 0x7fffffffu); }
  friend constexpr auto operator<=>(const PairKey&, const PairKey&) noexcept = default;
};

}  // namespace tactus
