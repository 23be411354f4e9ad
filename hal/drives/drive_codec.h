// The codecs of drive families: commands to frames, frames to answers. Pure functions, no I/O.
//
// One command and one answer per period and axis. decode() accepts any bytes and returns whether the frame is this
// drive's answer, foreign, or malformed. Sources, per family: mit_codec.h, robstride_codec.h, moteus_codec.h,
// odrive_codec.h. Units: SI, of the drive's reported shaft. Thread: [any], [rt]; no allocation, bounded.
#pragma once

#include <string_view>

#include "hal/drives/drive_axis.h"
#include "hal/drives/drive_frame.h"

namespace tactus::hal {

enum class DriveAction : std::uint8_t {
  kPoll = 0,     // ask for a sample; the drive stays disabled
  kEnable = 1,   // without torque
  kTorque = 2,   // torque and damping
  kBrake = 3,    // no torque; brake damping, or the motor shorted
  kDisable = 4,  // the axis is free
  kClear = 5,    // clear the drive's fault; it is disabled, or without torque
};

struct DriveCommand {
  DriveAction action{DriveAction::kPoll};
  double torque_Nm{0};
  double damping_Nms_per_rad{0};
  // For a field without an exact zero: a value midway between two steps is rounded up or down. The caller alternates
  // this, so that the mean of the values sent is exact.
  bool round_up{false};
};

enum class DriveMode : std::uint8_t {
  kUnknown = 0,
  kDisabled = 1,
  kEnabled = 2,
  kFaulted = 3,
  kTimedOut = 4,
  kStarting = 5,  // between disabled and enabled: no torque yet
  kOther = 6,     // enabled in a mode that is not the one of torque commands, such as a brake
};

struct DriveAnswer {
  bool has_position{false}, has_mode{false};
  double position_rad{0}, speed_rad_per_s{0}, torque_Nm{0};
  DriveMode mode{DriveMode::kUnknown};
  std::uint32_t fault{0};  // the family's own code; 0: none
};

enum class DriveDecode : std::uint8_t {
  kAnswer = 0,     // this drive's
  kForeign = 1,    // another identifier
  kMalformed = 2,  // this drive's identifier, but not an answer
};

struct DriveCodec {
  std::string_view name;  // in description files
  // size 0 and id 0: nothing is to be sent for this action.
  DriveFrame (*encode)(const DriveAxis& axis, const DriveCommand& command) noexcept;
  // Sets only the members of the answer that the frame contains; the others are unchanged.
  DriveDecode (*decode)(const DriveAxis& axis, const DriveFrame& frame, DriveAnswer& answer) noexcept;
  std::uint8_t command_bytes, answer_bytes;  // of the torque command and its answer
  bool extended_command, extended_answer;
  bool needs_fd;                             // its frames do not fit classic CAN
  bool damps;                                // it can close a damping term
  bool tells_enabled;                        // each answer to a torque command reports whether the drive is enabled
  bool has_float_position;                   // the frame has no quantum: counts_per_turn is needed
  double default_damping_range_Nms_per_rad;  // 0: there is none
  double damping_steps;                      // of the field from zero to its range
  bool tells_torque{true};                   // each answer to a torque command reports the drive's torque
};

const DriveCodec& codec_of(DriveFamily family) noexcept;

// Steps per turn of the axis in which the frames report its position: those of the field, or of the drive's encoder.
double drive_counts_per_turn(DriveFamily family, const DriveAxis& axis) noexcept;

// The damping that the frames carry for a requested one: a whole number of steps, never more than requested.
double sent_damping_Nms_per_rad(DriveFamily family, const DriveAxis& axis, double damping_Nms_per_rad) noexcept;

// A field of `bits` that spans +-range: nearest step, clamped; NaN gives the middle. `round_up` decides a tie.
std::uint32_t field_of(double value, double range, unsigned bits, bool round_up) noexcept;
double value_of_field(std::uint32_t field, double range, unsigned bits) noexcept;

}  // namespace tactus::hal
