// What USB adds to the wire: identity, the one interface, its endpoints and its requests. Both ends compile it.
//
// One vendor interface (class 0xff, subclass = the protocol's magic, protocol = the protocol's version) with an
// interrupt endpoint each way, 64 bytes, polled every millisecond at full speed and every microframe at high speed: the
// device sends one state frame per control period and has nothing to send in between. A frame is one packet. Their
// addresses are read from the descriptors: 0x81 and 0x02 unless the board's controller has others.
// Service messages go as vendor requests to the interface: the host writes the 16 bytes of a request, then reads the 16
// bytes of the reply. The device stalls the read while there is no reply: it comes within a control period or two.
// Configuration value 1. Windows binds WinUSB by the Microsoft OS 1.0 descriptors, under the vendor code below.
// Thread: [any]; constants.
#pragma once

#include <cstdint>

#include "firmware/protocol.h"

namespace tactus::firmware {

inline constexpr std::uint16_t kUsbVendor = 0x1209, kUsbProduct = 0x0001;  // pid.codes' number for tests
inline constexpr std::uint16_t kUsbDeviceRelease = 0x0100;                 // bcdDevice

inline constexpr std::uint8_t kUsbInterfaceClass = 0xff;
inline constexpr std::uint8_t kUsbInterfaceSubclass = kMagic;
inline constexpr std::uint8_t kUsbInterfaceProtocol = kProtocolVersion;

inline constexpr std::uint8_t kUsbStateEndpoint = 0x81;    // IN: to the host
inline constexpr std::uint8_t kUsbCommandEndpoint = 0x02;  // OUT: to the device
inline constexpr std::uint16_t kUsbPacketSize = 64;
inline constexpr std::uint8_t kUsbIntervalFullSpeed = 1;  // 1 ms
inline constexpr std::uint8_t kUsbIntervalHighSpeed = 1;  // 2^0 microframes, 125 us
static_assert(kUsbPacketSize >= kMaxFrameSize);

// bmRequestType: vendor, recipient the interface; wIndex: the interface's number; wValue 0; 16 bytes.
inline constexpr std::uint8_t kUsbRequestOut = 0x41, kUsbRequestIn = 0xc1;
inline constexpr std::uint8_t kUsbWriteService = 1, kUsbReadService = 2;

inline constexpr std::uint8_t kUsbMicrosoftVendorCode = 0x74;
// Windows programs find the device by it.
inline constexpr char kUsbInterfaceGuid[] = "{f5670343-2bed-4da8-bed6-07d43ceae6bf}";

}  // namespace tactus::firmware
