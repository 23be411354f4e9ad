#include "firmware/protocol.h"

#include <bit>

#include "firmware/little_endian.h"

namespace tactus::firmware {
namespace {

constexpr std::uint8_t kTypeState = 1, kTypeCommand = 2;
constexpr std::uint8_t kFlagRearm = 1u << 0;
constexpr std::size_t kCrcSize = 4;

// One entry per nibble: 64 bytes of flash instead of 1 KiB, two look-ups per byte.
constexpr std::array<std::uint32_t, 16> make_crc_table() noexcept {
  constexpr std::uint32_t reflected_polynomial = 0x82f63b78u;
  std::array<std::uint32_t, 16> table{};
  for (std::uint32_t nibble = 0; nibble < 16; ++nibble) {
    std::uint32_t value = nibble;
    for (int bit = 0; bit < 4; ++bit) value = (value & 1u) != 0 ? (value >> 1) ^ reflected_polynomial : value >> 1;
    table[nibble] = value;
  }
  return table;
}
constexpr std::array<std::uint32_t, 16> kCrcTable = make_crc_table();

void put_header(std::span<std::byte> out, std::uint8_t type, State state, std::uint32_t sequence) noexcept {
  put<std::uint8_t>(out, 0, kMagic);
  put<std::uint8_t>(out, 1, kProtocolVersion);
  put<std::uint8_t>(out, 2, type);
  put<std::uint8_t>(out, 3, static_cast<std::uint8_t>(state));
  put<std::uint32_t>(out, 4, sequence);
}

void put_crc(std::span<std::byte> out) noexcept {
  put<std::uint32_t>(out, out.size() - kCrcSize, crc32c(out.first(out.size() - kCrcSize)));
}

DecodeError check(std::span<const std::byte> in, std::size_t size, std::uint8_t type) noexcept {
  if (in.size() != size) return DecodeError::kWrongSize;
  if (get<std::uint8_t>(in, 0) != kMagic) return DecodeError::kWrongMagic;
  if (get<std::uint32_t>(in, size - kCrcSize) != crc32c(in.first(size - kCrcSize))) return DecodeError::kWrongCrc;
  if (get<std::uint8_t>(in, 1) != kProtocolVersion) return DecodeError::kWrongVersion;
  if (get<std::uint8_t>(in, 2) != type) return DecodeError::kWrongType;
  if (get<std::uint8_t>(in, 3) > static_cast<std::uint8_t>(State::kBrake)) return DecodeError::kWrongState;
  return DecodeError::kNone;
}

}  // namespace

std::uint32_t crc32c(std::span<const std::byte> bytes) noexcept { return crc32c_continued(0, bytes); }

std::uint32_t crc32c_continued(std::uint32_t crc, std::span<const std::byte> bytes) noexcept {
  crc = ~crc;
  for (const std::byte b : bytes) {
    crc ^= std::to_integer<std::uint32_t>(b);
    crc = kCrcTable[crc & 0xfu] ^ (crc >> 4);
    crc = kCrcTable[crc & 0xfu] ^ (crc >> 4);
  }
  return ~crc;
}

void encode_state(const StateFrame& frame, std::span<std::byte, kStateFrameSize> out) noexcept {
  put_header(out, kTypeState, frame.state, frame.sequence);
  put<std::uint64_t>(out, 8, frame.time_us);
  for (std::size_t i = 0; i < kAxes; ++i)
    put<std::uint32_t>(out, 16 + 4 * i, static_cast<std::uint32_t>(frame.counts[i]));
  put<std::uint32_t>(out, 40, frame.echoed_sequence);
  put<std::uint16_t>(out, 44, frame.fault);
  put<std::uint16_t>(out, 46, frame.limits);
  put<std::uint8_t>(out, 48, frame.buttons);
  put<std::uint8_t>(out, 49, frame.missed_commands);
  put<std::uint16_t>(out, 50, 0);
  put_crc(out);
}

void encode_command(const CommandFrame& frame, std::span<std::byte, kCommandFrameSize> out) noexcept {
  put_header(out, kTypeCommand, frame.wanted, frame.sequence);
  put<std::uint32_t>(out, 8, frame.rearm ? kFlagRearm : 0u);
  for (std::size_t i = 0; i < kAxes; ++i)
    put<std::uint32_t>(out, 12 + 4 * i, std::bit_cast<std::uint32_t>(frame.effort[i]));
  put_crc(out);
}

DecodeError decode_state(std::span<const std::byte> bytes, StateFrame& frame) noexcept {
  if (const DecodeError error = check(bytes, kStateFrameSize, kTypeState); error != DecodeError::kNone) return error;
  if (get<std::uint16_t>(bytes, 50) != 0) return DecodeError::kReservedNotZero;
  frame.state = static_cast<State>(get<std::uint8_t>(bytes, 3));
  frame.sequence = get<std::uint32_t>(bytes, 4);
  frame.time_us = get<std::uint64_t>(bytes, 8);
  for (std::size_t i = 0; i < kAxes; ++i)
    frame.counts[i] = static_cast<std::int32_t>(get<std::uint32_t>(bytes, 16 + 4 * i));
  frame.echoed_sequence = get<std::uint32_t>(bytes, 40);
  frame.fault = get<std::uint16_t>(bytes, 44);
  frame.limits = get<std::uint16_t>(bytes, 46);
  frame.buttons = get<std::uint8_t>(bytes, 48);
  frame.missed_commands = get<std::uint8_t>(bytes, 49);
  return DecodeError::kNone;
}

DecodeError decode_command(std::span<const std::byte> bytes, CommandFrame& frame) noexcept {
  if (const DecodeError error = check(bytes, kCommandFrameSize, kTypeCommand); error != DecodeError::kNone)
    return error;
  const auto wanted = static_cast<State>(get<std::uint8_t>(bytes, 3));
  if (wanted == State::kReset) return DecodeError::kWrongState;
  const auto flags = get<std::uint32_t>(bytes, 8);
  if ((flags & ~std::uint32_t{kFlagRearm}) != 0) return DecodeError::kReservedNotZero;
  frame.wanted = wanted;
  frame.rearm = (flags & kFlagRearm) != 0;
  frame.sequence = get<std::uint32_t>(bytes, 4);
  for (std::size_t i = 0; i < kAxes; ++i) frame.effort[i] = std::bit_cast<float>(get<std::uint32_t>(bytes, 12 + 4 * i));
  return DecodeError::kNone;
}

}  // namespace tactus::firmware
