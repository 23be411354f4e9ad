// The Falcon's packets: 16 characters each way, one answer per request.
//
// '<', three numbers of 16 bits as four characters 'A' + nibble, least significant first, a character of bits, 'A',
// '>'. Bits to the device: 1 homing, 2, 4, 8 green, blue, red light. From it: 1, 2, 4, 8 the buttons, 16, 32, 64 the
// homed axes. Source: libnifalcon and the ROS drivers; not tried on a device.
// Thread: the functions [any], [rt], pure; a FalconScanner: one owner, [rt]. Units: counts of the encoders, the
// device's numbers for a motor. Errors: a packet that does not decode is dropped and counted.
#pragma once

#include <array>
#include <cstdint>
#include <span>

namespace tactus::hal {

inline constexpr std::size_t kFalconPacket = 16;
using FalconBytes = std::array<std::uint8_t, kFalconPacket>;

struct FalconRequest {
  std::array<std::int16_t, 3> motors{};
  bool homing{true}, green{false}, blue{false}, red{false};
};

struct FalconState {
  std::array<std::int16_t, 3> counts{};
  std::uint8_t buttons{0};  // bit 0: right, 1: forward, 2: centre, 3: left
  std::uint8_t homed{0};    // bit of each axis
};

inline FalconBytes encode_falcon(const FalconRequest& request) noexcept {
  FalconBytes bytes{};
  bytes[0] = '<';
  for (unsigned motor = 0; motor < 3; ++motor)
    for (unsigned nibble = 0; nibble < 4; ++nibble) {
      const auto value = static_cast<std::uint16_t>(request.motors[motor]);
      bytes[1 + 4 * motor + nibble] = static_cast<std::uint8_t>('A' + (value >> (4 * nibble) & 0xf));
    }
  bytes[13] = static_cast<std::uint8_t>('A' + (request.homing ? 1 : 0) + (request.green ? 2 : 0) +
                                        (request.blue ? 4 : 0) + (request.red ? 8 : 0));
  bytes[14] = 'A';
  bytes[15] = '>';
  return bytes;
}

// False: it is not a packet of the device, and `state` is unchanged.
inline bool decode_falcon(std::span<const std::uint8_t, kFalconPacket> bytes, FalconState& state) noexcept {
  if (bytes[0] != '<' || bytes[15] != '>') return false;
  FalconState read;
  for (unsigned axis = 0; axis < 3; ++axis) {
    unsigned value = 0;
    for (unsigned nibble = 0; nibble < 4; ++nibble) {
      const unsigned digit = bytes[1 + 4 * axis + nibble] - static_cast<unsigned>('A');
      if (digit > 15) return false;
      value |= digit << (4 * nibble);
    }
    read.counts[axis] = static_cast<std::int16_t>(value);
  }
  const unsigned bits = bytes[13] - static_cast<unsigned>('A');
  if (bits > 0x7f) return false;
  read.buttons = static_cast<std::uint8_t>(bits & 0xf);
  read.homed = static_cast<std::uint8_t>(bits >> 4 & 7);
  state = read;
  return true;
}

// Finds packets in a stream of bytes that may begin and end anywhere: '<', 14 characters, '>'.
class FalconScanner {
 public:
  // True: this byte ended a packet, and `state` holds it.
  bool take(std::uint8_t byte, FalconState& state) noexcept {
    if (byte == '<') size_ = 0;
    if (size_ == kFalconPacket || (size_ == 0 && byte != '<')) return false;
    bytes_[size_++] = byte;
    if (byte != '>') return false;
    const bool whole = size_ == kFalconPacket && decode_falcon(bytes_, state);
    broken_ += !whole;
    size_ = 0;
    return whole;
  }
  std::uint64_t broken() const noexcept { return broken_; }

 private:
  FalconBytes bytes_{};
  std::size_t size_{0};
  std::uint64_t broken_{0};
};

}  // namespace tactus::hal
