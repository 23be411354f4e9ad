// The USB part of the protocol: identity, the interface, its endpoints and its requests. Compiled into both ends.
//
// One vendor interface (class 0xff, subclass = the protocol's magic, protocol = the protocol's version) with one
// interrupt endpoint in each direction, 64 bytes, polled every millisecond at full speed and every microframe at high
// speed. The device sends one state frame per control period and nothing in between. A frame is one packet. The host
// reads the endpoint addresses from the descriptors: 0x81 and 0x02 unless the board's controller uses others.
// Service messages are vendor requests to the interface: the host writes the 16 bytes of a request, then reads the 16
// bytes of the reply. The device stalls the read until the reply is there, within one or two control periods.
// Configuration value 1. Windows binds WinUSB by the Microsoft OS 1.0 descriptors, under the vendor code below.
// Thread: [any]; constants.
#pragma once

#include <cstdint>

#include "firmware/protocol.h"

namespace tactus::firmware {

inline constexpr std::uint16_t kUsbVendor = 0x1209, kUsbProduct = 0x0001;  // the test product ID of pid.codes
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
// Device interface GUID by which Windows programs find the device.
inline constexpr char kUsbInterfaceGuid[] = "{f5670343-2bed-4da8-bed6-07d43ceae6bf}";

}  // namespace tactus::firmware
