// Reads and writes unsigned numbers in little-endian byte order (the wire's), independent of the processor's order.
//
// Thread: [any]; pure functions. Bound: the caller ensures that offset and size lie inside the span.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace tactus::firmware {

template <class U>
void put(std::span<std::byte> out, std::size_t offset, U value) noexcept {
  for (std::size_t i = 0; i < sizeof(U); ++i) out[offset + i] = static_cast<std::byte>((value >> (8 * i)) & 0xffu);
}

template <class U>
U get(std::span<const std::byte> in, std::size_t offset) noexcept {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < sizeof(U); ++i) value |= std::to_integer<std::uint64_t>(in[offset + i]) << (8 * i);
  return static_cast<U>(value);
}

}  // namespace tactus::firmware
