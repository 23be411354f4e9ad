// FNV-1a, 64 bit: hashes of states and tapes, to compare two runs. Not for hash tables, not against an adversary.
//
// Only initialised bytes may be hashed: a value whose type can have no padding is hashed whole, others member by
// member. Thread: [any]. Bound: linear in the bytes. Source: Fowler, Noll, Vo; RFC 9923.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string_view>
#include <type_traits>

namespace tactus {

class Fnv1a {
 public:
  void add_bytes(std::span<const std::byte> bytes) noexcept {
    for (const std::byte b : bytes) value_ = (value_ ^ static_cast<std::uint64_t>(b)) * kPrime;
  }
  void add_text(std::string_view text) noexcept { add_bytes(std::as_bytes(std::span(text.data(), text.size()))); }

  // Numbers, enumerations, and structs of integers without padding. A double is hashed by its bits: -0 differs from 0.
  template <class T>
  void add(const T& value) noexcept {
    static_assert(std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>, "may have padding");
    static_assert(!std::is_same_v<T, long double>, "has padding");
    static_assert(!std::is_pointer_v<T>, "an address differs from run to run");
    add_bytes(std::as_bytes(std::span<const T, 1>(&value, 1)));
  }

  std::uint64_t value() const noexcept { return value_; }

 private:
  static constexpr std::uint64_t kPrime = 0x00000100000001b3ull;
  std::uint64_t value_{0xcbf29ce484222325ull};
};

inline std::uint64_t fnv1a(std::span<const std::byte> bytes) noexcept {
  Fnv1a hash;
  hash.add_bytes(bytes);
  return hash.value();
}

}  // namespace tactus
