// moteus (mjbots): CAN FD, registers written and read by sub-frames.
//
// A torque command and its query are one frame: mode = position, position NaN (no position term), feed-forward torque,
// kp scale 0, kd scale for the damping, time-out in ms; then a query of mode, position, velocity, torque, fault. The
// mode is written first, because writing it resets the other fields. The time-out acts in mode 10 alone, so mode 9
// (current), which has none, is not used. An answer reports the mode before its command: the drive acts on a frame
// when it has answered it. From stopped it takes 10 to 15 ms to mode 10, through the modes 2 to 4, without torque: the
// gate driver starts, and 256 control cycles measure the currents' zeros. So a drive that has restarted, or was
// stopped, reports that in ten answers and more. Source: mjbots/moteus db1a762 (Apache-2.0), docs/protocol and fw/; not
// tried on a drive. Thread: [any], [rt].
#pragma once

#include <string>
#include <string_view>

#include "hal/drives/drive_codec.h"

namespace tactus::hal {

extern const DriveCodec kMoteusCodec;

inline constexpr std::uint8_t kMoteusStopped = 0, kMoteusFault = 1, kMoteusFirstStart = 2, kMoteusLastStart = 4,
                              kMoteusPosition = 10, kMoteusTimedOut = 11, kMoteusBrake = 15;
inline constexpr int kMoteusTimeout_ms = 10;

// Registers that are read when the arm is opened.
enum class MoteusRegister : std::uint16_t {
  kMode = 0x00,
  kHomeState = 0x0c,  // 0 none, 1 rotor alone, 2 output
  kModel = 0x100,
  kFirmware = 0x101,
  kRegisterMap = 0x102,
  kSerial1 = 0x120,  // and the two after it
};

// Reads `count` (1 to 3) registers as i32.
DriveFrame moteus_read(unsigned id, MoteusRegister first, unsigned count) noexcept;
// True if `frame` is from this drive and holds an i32 of the register.
bool parse_moteus_register(const DriveAxis& axis, MoteusRegister number, const DriveFrame& frame,
                           std::int32_t& value) noexcept;

// The drive's text console, through the bus: a question without an answer frame, then polls for its text. Set-up alone:
// decode() takes a frame with text for a malformed one.
inline constexpr const char* kMoteusTimeoutMode = "servo.timeout_mode";
DriveFrame moteus_ask_configuration(unsigned id, std::string_view key) noexcept;  // key: at most 32 letters
DriveFrame moteus_poll_text(unsigned id) noexcept;
// True if `frame` is from this drive and answers a poll; its text is added.
bool take_moteus_text(const DriveAxis& axis, const DriveFrame& frame, std::string& text);

}  // namespace tactus::hal
