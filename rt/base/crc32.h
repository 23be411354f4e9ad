// CRC-32 (IEEE 802.3: polynomial 0x04c11db7 reflected, start and final xor all ones): detects damage in files.
//
// Detects every single-bit flip and every burst of up to 32 bits. Thread: [any]; not used in the tick.
// Bound: linear in the bytes, one table look-up a byte.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tactus {

namespace detail {

constexpr std::array<std::uint32_t, 256> make_crc32_table() noexcept {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    std::uint32_t remainder = i;
    for (int bit = 0; bit < 8; ++bit) remainder = (remainder >> 1) ^ ((remainder & 1u) != 0 ? 0xedb88320u : 0u);
    table[i] = remainder;
  }
  return table;
}
inline constexpr std::array<std::uint32_t, 256> kCrc32Table = make_crc32_table();

}  // namespace detail

class Crc32 {
 public:
  constexpr void add_bytes(std::span<const std::byte> bytes) noexcept {
    for (const std::byte b : bytes)
      state_ = detail::kCrc32Table[(state_ ^ static_cast<std::uint32_t>(b)) & 0xffu] ^ (state_ >> 8);
  }
  constexpr std::uint32_t value() const noexcept { return ~state_; }

 private:
  std::uint32_t state_{0xffffffffu};
};

}  // namespace tactus
