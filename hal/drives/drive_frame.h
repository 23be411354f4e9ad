// A frame on a drive's CAN bus, and byte access in both orders. Thread: [any]; plain values. Bound: put() adds to at
// most 64 bytes; the caller counts them.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <initializer_list>
#include <span>

namespace tactus::hal {

struct DriveFrame {
  std::uint32_t id{0};   // 11 bits, or 29 if extended
  bool extended{false};  // 29-bit identifier
  bool fd{false};        // CAN FD with the bit rate switched
  std::uint8_t size{0};  // bytes; 0 to 8, or a CAN FD length up to 64
  std::array<std::uint8_t, 64> data{};

  std::span<const std::uint8_t> bytes() const noexcept { return {data.data(), size}; }
  void put(std::initializer_list<std::uint8_t> values) noexcept {
    for (const std::uint8_t value : values) data[size++] = value;
  }
  void put_f32(float value) noexcept {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    for (unsigned i = 0; i < 4; ++i) data[size++] = static_cast<std::uint8_t>(bits >> (8 * i));
  }
  void put_u32(std::uint32_t value) noexcept { put_f32(std::bit_cast<float>(value)); }
  friend bool operator==(const DriveFrame&, const DriveFrame&) noexcept = default;
};

// Little-endian, from byte `at` on; the caller must have checked the length.
inline std::uint32_t u32_at(const DriveFrame& frame, unsigned at) noexcept {
  std::uint32_t value = 0;
  for (unsigned i = 0; i < 4; ++i) value |= static_cast<std::uint32_t>(frame.data[at + i]) << (8 * i);
  return value;
}
inline float f32_at(const DriveFrame& frame, unsigned at) noexcept { return std::bit_cast<float>(u32_at(frame, at)); }
inline std::uint16_t u16_at(const DriveFrame& frame, unsigned at) noexcept {
  return static_cast<std::uint16_t>(frame.data[at] | frame.data[at + 1] << 8);
}
// Big-endian.
inline std::uint16_t be16_at(const DriveFrame& frame, unsigned at) noexcept {
  return static_cast<std::uint16_t>(frame.data[at] << 8 | frame.data[at + 1]);
}

}  // namespace tactus::hal
