// Faults of a device that tactus itself finds or translates: those of an arm of drives, of a maker's library, of a
// Falcon. They have bit 31 set, which no device can send: the wire of firmware/PROTOCOL.md has 16 bits for a fault,
// and a number of a user's device class that has the bit becomes the largest without it (without_host_bit). So a number
// of tactus is never taken for a device's own.
//
//   1 to 31, and all without the bit   the device's own: words of firmware/faults.h where they are known
//   kOfHost | 32 to 63                 drives/drive_faults.h
//   kOfHost | 80 to 95                 falcon/falcon_faults.h
//   kOfHost | 96 to 127                sdk/sdk_faults.h
// Numbers are never reused. Thread: [any].
#pragma once

#include <cstdint>

namespace tactus::hal {

inline constexpr std::uint32_t kOfHost = 1u << 31;

// The number for people and files: what else a fault carries (drives/drive_faults.h) is left out.
constexpr std::uint32_t shown_fault(std::uint32_t fault) noexcept {
  return (fault & kOfHost) != 0 ? fault & 0xffu : fault;
}

// Of a number from outside.
constexpr std::uint32_t without_host_bit(std::uint32_t fault) noexcept {
  return (fault & kOfHost) != 0 ? kOfHost - 1 : fault;
}

}  // namespace tactus::hal
