// Service messages, separate from the two control frames: identity, configuration and diagnosis of the device.
//
// One request, one reply, both with the same eight bytes of content, small enough for a classic CAN frame; the host
// sends the next request after the reply to the last. They use other channels than the control frames (USB: vendor
// requests on endpoint 0; CAN: separate identifiers), so requests do not disturb the loop. The content (offset: field):
//    0 u8   operation, low four bits; status, high four bits: 0 in a request
//    1 u8   tag, chosen by the host, returned in the reply
//    2 u16  register number
//    4 u32  value: an integer, or the bits of a float, as the register's type says; 0 in a read request
// On CAN this is the whole frame. On USB a frame has 16 bytes: magic, version, type 3 (request) or 4 (reply), 0,
// content, CRC-32C of the twelve bytes before. Little-endian. Thread: [any]; no state, no allocation, bounded.
#pragma once

#include "firmware/protocol.h"

namespace tactus::firmware {

inline constexpr std::size_t kServiceContentSize = 8, kServiceFrameSize = 16;

enum class Operation : std::uint8_t {
  kRead = 1,
  kWrite = 2,
  kExecute = 3,  // a command register: value is its argument
};

enum class ServiceStatus : std::uint8_t {
  kGood = 0,
  kNoSuchRegister = 1,
  kReadOnly = 2,
  kOutOfRange = 3,  // the register does not accept the value, finite or not; nothing changed
  kWrongState = 4,  // not allowed in the device's present state (most writes need IDLE or BRAKE)
  kNoSuchOperation = 5,
  kBusy = 6,  // homing or a save is in progress, or a change is not active yet
};

struct ServiceMessage {
  Operation operation{Operation::kRead};
  ServiceStatus status{ServiceStatus::kGood};
  std::uint8_t tag{0};
  std::uint16_t address{0};
  std::uint32_t value{0};
  friend constexpr bool operator==(const ServiceMessage&, const ServiceMessage&) noexcept = default;
};

enum class ServiceDirection : std::uint8_t { kRequest = 3, kReply = 4 };

void encode_service_content(const ServiceMessage& message, std::span<std::byte, kServiceContentSize> out) noexcept;
// Operation and status are not checked: the device replies kNoSuchOperation to an unknown operation.
[[nodiscard]] bool decode_service_content(std::span<const std::byte> bytes, ServiceMessage& message) noexcept;

void encode_service(const ServiceMessage& message, ServiceDirection direction,
                    std::span<std::byte, kServiceFrameSize> out) noexcept;
// On an error `message` is unchanged.
[[nodiscard]] DecodeError decode_service(std::span<const std::byte> bytes, ServiceDirection direction,
                                         ServiceMessage& message) noexcept;

}  // namespace tactus::firmware
