// ODrive, CANSimple: classic CAN, identifier node << 5 | command, little-endian.
//
// The drive sends its encoder's estimate cyclically and a heartbeat every 100 ms, by its own clock, so a poll sends
// nothing. It has no damping term in torque control and no brake: on a lost host it coasts.
// Sources: odriverobotics/ODrive v0.5.6, ODriveArduino, ros_odrive; not tried on a drive. Thread: [any], [rt].
#pragma once

#include "hal/drives/drive_codec.h"

namespace tactus::hal {

extern const DriveCodec kOdriveCodec;

inline constexpr std::uint32_t kOdriveIdle = 1, kOdriveClosedLoop = 8;
enum class OdriveCommand : std::uint32_t {
  kHeartbeat = 0x01,
  kAxisState = 0x07,
  kEstimates = 0x09,
  kControllerMode = 0x0b,  // u32 1: torque, u32 1: direct input
  kInputTorque = 0x0e,
  kClearErrors = 0x18,
};

// What a heartbeat says after the watchdog has acted, with firmware 0.5 and 0.6.
inline constexpr std::uint32_t kOdriveWatchdog05 = 0x800, kOdriveWatchdog06 = 1u << 24;

DriveFrame odrive_torque_mode(unsigned node) noexcept;
// True if `frame` is a heartbeat of this node.
bool parse_odrive_heartbeat(const DriveAxis& axis, const DriveFrame& frame, std::uint32_t& error,
                            std::uint32_t& state) noexcept;

}  // namespace tactus::hal
