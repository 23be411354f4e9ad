// The protocol between device and host: the one definition, compiled into both ends.
//
// Two frames of fixed size, little-endian, one of each per control period. Both fit a full-speed USB interrupt packet
// and a CAN FD frame (64 bytes). Layout of version 1 (offset: field):
//
//   state, 56 bytes, device to host                    command, 40 bytes, host to device
//    0 u8      magic 0x74                               0 u8      magic 0x74
//    1 u8      version 1                                1 u8      version 1
//    2 u8      type 1                                   2 u8      type 2
//    3 u8      state                                    3 u8      wanted state: IDLE, FORCE or BRAKE
//    4 u32     sequence, wraps                          4 u32     sequence, wraps
//    8 u64     device time [us]                         8 u8      flags: bit 0 re-arm, others 0
//   16 i32 x6  counts of the axes                       9 u8 x3   0
//   40 u32     sequence of the newest accepted command 12 f32 x6  efforts of the axes [N, N m]
//   44 u16     fault number (faults.h)                 36 u32     CRC-32C of bytes 0 to 35
//   46 u16     limit bits (faults.h)
//   48 u8      buttons
//   49 u8      command frames missed in a row, saturates at 255
//   50 u16     0
//   52 u32     CRC-32C of bytes 0 to 51
//
// In every version the last four bytes are the CRC of all the others. CRC-32C detects every error of up to five bits in
// frames of this size, and every burst of up to 32 bits. Thread: [any]; no state, no allocation, bounded.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/encoder.h"

namespace tactus::firmware {

inline constexpr std::uint8_t kMagic = 0x74, kProtocolVersion = 1;
inline constexpr std::size_t kStateFrameSize = 56, kCommandFrameSize = 40, kMaxFrameSize = 64;
static_assert(kStateFrameSize <= kMaxFrameSize && kCommandFrameSize <= kMaxFrameSize);

enum class State : std::uint8_t {
  kReset = 0,  // waits for its supply; motors shorted
  kIdle = 1,   // motors free
  kForce = 2,  // efforts of the newest command are applied
  kBrake = 3,  // motors shorted, latched until re-armed
};

struct StateFrame {
  State state{State::kReset};
  std::uint8_t buttons{0};  // bit 0 first
  std::uint8_t missed_commands{0};
  std::uint16_t fault{0};   // firmware::Fault
  std::uint16_t limits{0};  // bits of firmware::Limit
  std::uint32_t sequence{0};
  std::uint32_t echoed_sequence{0};
  std::uint64_t time_us{0};  // device clock at the sample
  AxisCounts counts{};
  friend constexpr bool operator==(const StateFrame&, const StateFrame&) noexcept = default;
};

struct CommandFrame {
  State wanted{State::kIdle};  // never kReset
  bool rearm{false};           // leaves BRAKE on its rising edge
  std::uint32_t sequence{0};
  std::array<float, kAxes> effort{};  // N on prismatic axes, N m on rotary ones
  friend constexpr bool operator==(const CommandFrame&, const CommandFrame&) noexcept = default;
};

// Why bytes are not a valid frame. Numbers are never reused. The first that applies is reported, in this order.
enum class DecodeError : std::uint8_t {
  kNone = 0,
  kWrongSize = 1,
  kWrongMagic = 2,
  kWrongCrc = 3,
  kWrongVersion = 4,
  kWrongType = 5,
  kWrongState = 6,  // a state number that does not exist, or RESET requested
  kReservedNotZero = 7,
};

// CRC-32C (Castagnoli), reflected, initial value and final exclusive-or 0xffffffff; of "123456789": 0xe3069283.
std::uint32_t crc32c(std::span<const std::byte> bytes) noexcept;
// CRC of data in pieces: `crc` is the CRC of the previous pieces, 0 for none.
std::uint32_t crc32c_continued(std::uint32_t crc, std::span<const std::byte> bytes) noexcept;

void encode_state(const StateFrame& frame, std::span<std::byte, kStateFrameSize> out) noexcept;
void encode_command(const CommandFrame& frame, std::span<std::byte, kCommandFrameSize> out) noexcept;

// On an error `frame` is unchanged. Efforts are not checked here: the controller rejects NaN.
[[nodiscard]] DecodeError decode_state(std::span<const std::byte> bytes, StateFrame& frame) noexcept;
[[nodiscard]] DecodeError decode_command(std::span<const std::byte> bytes, CommandFrame& frame) noexcept;

// True if sequence `a` is after `b`, modulo the wrap: up to half the range ahead.
constexpr bool is_newer(std::uint32_t a, std::uint32_t b) noexcept { return static_cast<std::int32_t>(a - b) > 0; }

}  // namespace tactus::firmware
