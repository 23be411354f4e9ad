// The MIT frame: Damiao, CubeMars/T-Motor AK, mini-cheetah derivatives. Classic CAN, 11-bit identifiers.
//
// Command, 8 bytes, to the motor's id, high byte first: position 16 bit, speed 12, kp 12, kd 12, torque 12. Position
// and kp are not used here: kp is 0. Special frames are seven FF and FC enable, FD disable, FB clear a fault (Damiao).
// FE, which would move the drive's zero, is never sent. Answer, on the motor's master id: id and status, position 16,
// speed 12, torque 12, temperatures. Sources: bgkatz/motorcontrol, enactic/openarm_can, cmjang/DM_Control_Python,
// jia-xie/python-damiao-driver; read in devices of their owners, not tried on one. Thread: [any], [rt].
#pragma once

#include "hal/drives/drive_codec.h"

namespace tactus::hal {

extern const DriveCodec kDamiaoCodec, kCubeMarsCodec, kMiniCheetahCodec;

// Status in Damiao's answers.
inline constexpr std::uint32_t kDamiaoHostLost = 0xd;

// --- Damiao's registers, by frames with the identifier kDamiaoRegisterId.
inline constexpr std::uint32_t kDamiaoRegisterId = 0x7ff;
enum class DamiaoRegister : std::uint8_t {
  kMasterId = 7,        // u32
  kMotorId = 8,         // u32
  kTimeout = 9,         // u32, steps of 50 us, 0: off
  kControlMode = 10,    // u32, 1: MIT
  kPositionRange = 21,  // f32, rad
  kSpeedRange = 22,     // f32, rad/s
  kTorqueRange = 23,    // f32, N m
};
inline constexpr double kDamiaoTimeoutStep_s = 50e-6;

DriveFrame damiao_read(unsigned motor_id, DamiaoRegister number) noexcept;
DriveFrame damiao_write(unsigned motor_id, DamiaoRegister number, std::uint32_t value) noexcept;  // in RAM
// True if `frame` is the answer of this motor to a read or write of this register.
bool parse_damiao_register(const DriveAxis& axis, DamiaoRegister number, const DriveFrame& frame,
                           std::uint32_t& value) noexcept;

}  // namespace tactus::hal
