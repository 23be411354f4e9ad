// Identifiers that are constant over a run. Thread: [any].
#pragma once

#include <compare>
#include <cstdint>

namespace tactus {

// Index of a body in its scene: dense, from 0, in the order of the scene file, which also orders slots, pairs and ties.
using BodyId = std::uint32_t;
inline constexpr BodyId kNoBody = 0xffffffffu;
inline constexpr unsigned kIdBits = 24, kPartBits = 7;  // two ids, two parts and a flag share one 64-bit key
inline constexpr BodyId kMaxBodyId = (1u << kIdBits) - 2;

// Parts of one body (physics/shapes/compound.h): part p has index p; a body of one shape has part 0 only.
inline constexpr std::uint32_t kMaxParts = 1u << kPartBits;

// A convex part of a body.
struct BodyPart {
  BodyId body{kNoBody};
  std::uint32_t part{0};
};

// Key of a pair of bodies, or of their parts, that may touch. Pairs with a fixed body sort after all others, so that a
// sweep ends with them; then by lower id, higher id, and the parts in the same order: the keys of two bodies are
// consecutive.
struct PairKey {
  std::uint64_t value{0};

  static constexpr PairKey of(BodyPart a, BodyPart b, bool with_fixed) noexcept {
    const BodyPart low = a.body < b.body ? a : b, high = a.body < b.body ? b : a;
    return {(with_fixed ? 1ull << 63 : 0ull) | (static_cast<std::uint64_t>(low.body) << kLowShift) |
            (static_cast<std::uint64_t>(high.body) << kHighShift) |
            (static_cast<std::uint64_t>(low.part) << kPartBits) | high.part};
  }
  static constexpr PairKey of(BodyId a, BodyId b, bool with_fixed) noexcept {
    return of(BodyPart{a, 0}, BodyPart{b, 0}, with_fixed);
  }
  constexpr bool with_fixed() const noexcept { return (value >> 63) != 0; }
  constexpr BodyId low() const noexcept { return static_cast<BodyId>((value >> kLowShift) & kIdMask); }
  constexpr BodyId high() const noexcept { return static_cast<BodyId>((value >> kHighShift) & kIdMask); }
  constexpr std::uint32_t low_part() const noexcept {
    return static_cast<std::uint32_t>(value >> kPartBits) & (kMaxParts - 1);
  }
  constexpr std::uint32_t high_part() const noexcept { return static_cast<std::uint32_t>(value) & (kMaxParts - 1); }
  // Both parts as one number, unique within the pair of bodies; 0 for bodies of one shape.
  constexpr std::uint32_t parts() const noexcept {
    return static_cast<std::uint32_t>(value) & (kMaxParts * kMaxParts - 1);
  }
  // The part of one of the two bodies.
  constexpr std::uint32_t part_of(BodyId body) const noexcept { return body == low() ? low_part() : high_part(); }
  // The key of the two bodies' first parts: the lowest of all their keys.
  constexpr PairKey of_bodies() const noexcept { return {value - parts()}; }
  friend constexpr auto operator<=>(const PairKey&, const PairKey&) noexcept = default;

 private:
  static constexpr unsigned kHighShift = 2 * kPartBits, kLowShift = kHighShift + kIdBits;
  static constexpr std::uint64_t kIdMask = (1u << kIdBits) - 1;
  static_assert(kLowShift + kIdBits < 63);
};

}  // namespace tactus
