// RobStride and Xiaomi CyberGear, their private protocol: classic CAN, 29-bit identifiers of
// type << 24 | 16 bits of data << 8 | target id.
//
// The torque is in the identifier of a control frame. 16-bit fields are floor((x / M + 1) 0x7fff), so zero is exact.
// Polls read parameter 0x7019, the position, because a stopped drive is not known to answer control frames.
// Sources: RobStride/Python_Sample (MIT licence), huggingface/lerobot; not tried on a drive. Torque ranges of RS00,
// RS02, RS05 and RS06 differ between sources. Thread: [any], [rt].
#pragma once

#include "hal/drives/drive_codec.h"

namespace tactus::hal {

extern const DriveCodec kRobStrideCodec;

inline constexpr std::uint32_t kRobStrideHost = 0xfd;
enum class RobStrideParameter : std::uint16_t {
  kRunMode = 0x7005,      // u8, 0: control
  kTorqueLimit = 0x700b,  // f32, N m
  kPosition = 0x7019,     // f32, rad
  kTimeout = 0x7028,      // u32, steps of 50 us, 0: off
};
inline constexpr double kRobStrideTimeoutStep_s = 50e-6;

DriveFrame robstride_ask_id(unsigned motor_id) noexcept;
DriveFrame robstride_read(unsigned motor_id, RobStrideParameter index) noexcept;
DriveFrame robstride_write(unsigned motor_id, RobStrideParameter index, std::uint32_t value) noexcept;
// True if `frame` answers a read of this parameter. A parameter that the firmware does not have: `known` is false.
bool parse_robstride_parameter(const DriveAxis& axis, RobStrideParameter index, const DriveFrame& frame,
                               std::uint32_t& value, bool& known) noexcept;
// True if `frame` answers robstride_ask_id: the 64 bits of the drive's chip.
bool parse_robstride_id(const DriveAxis& axis, const DriveFrame& frame, std::uint64_t& chip) noexcept;

}  // namespace tactus::hal
