// Identity of a device, which a host reads first: class, serial number, versions.
//
// A board supplies it once, at construction. Thread: [any]; constants.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace tactus::firmware {

// Revision of the table of registers, which may grow under the same protocol version (PROTOCOL.md).
inline constexpr std::uint32_t kRegisterRevision = 3;
// Major in bits 16 and up, minor in 8 to 15, patch in 0 to 7.
inline constexpr std::uint32_t kFirmwareVersion = 0x000100;

// Type of mechanism behind the six axes. Numbers are never reused; a host can read counts and send efforts without
// knowing the class.
enum class MechanismClass : std::uint32_t {
  kUnknown = 0,
  kDesk3 = 1,     // three translations, no motor on the rotations
  kVirtuose6 = 2  // three translations and a wrist
};

inline constexpr std::size_t kSerialSize = 16, kSerialWords = kSerialSize / 4;

struct Identity {
  MechanismClass device_class{MechanismClass::kUnknown};
  std::array<char, kSerialSize> serial{};  // ASCII, padded with zeros
};

// The first sixteen characters of `serial`.
constexpr Identity make_identity(MechanismClass device_class, std::string_view serial) noexcept {
  Identity identity{device_class, {}};
  for (std::size_t i = 0; i < kSerialSize && i < serial.size(); ++i) identity.serial[i] = serial[i];
  return identity;
}

// Characters 4 k to 4 k + 3, the first in the lowest byte. k < kSerialWords.
constexpr std::uint32_t serial_word(const Identity& identity, std::size_t k) noexcept {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i)
    word |= static_cast<std::uint32_t>(static_cast<unsigned char>(identity.serial[4 * k + i])) << (8 * i);
  return word;
}

}  // namespace tactus::firmware
