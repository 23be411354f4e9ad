#include "hal/drives/robstride_codec.h"

#include <algorithm>
#include <cmath>

namespace tactus::hal {
namespace {

constexpr std::uint32_t kAskId = 0, kControl = 1, kAnswer = 2, kEnable = 3, kStop = 4, kRead = 17, kWrite = 18;
constexpr std::uint32_t kFaultBits = 0x3f;
constexpr double kMiddle = 0x7fff, kDampingSteps = 65535;

DriveFrame frame_of(std::uint32_t type, std::uint32_t data16, unsigned motor_id) noexcept {
  return {.id = type << 24 | data16 << 8 | (motor_id & 0xffu), .extended = true};
}

std::uint32_t middle_field(double value, double range) noexcept {
  if (!std::isfinite(value) || range <= 0) return 0x7fff;
  return static_cast<std::uint32_t>(std::clamp(std::floor((value / range + 1) * kMiddle + 0.5), 0.0, 65534.0));
}

double middle_value(std::uint16_t field, double range) noexcept { return (field / kMiddle - 1) * range; }

DriveFrame plain(std::uint32_t type, unsigned motor_id, std::uint8_t first_byte) noexcept {
  DriveFrame frame = frame_of(type, kRobStrideHost, motor_id);
  frame.put({first_byte, 0, 0, 0, 0, 0, 0, 0});
  return frame;
}

DriveFrame control(const DriveAxis& axis, double torque_Nm, double damping) noexcept {
  DriveFrame frame = frame_of(kControl, middle_field(torque_Nm, axis.torque_range_Nm), axis.id);
  const double range = axis.damping_range_Nms_per_rad;
  const double share = std::isfinite(damping) && range > 0 ? std::clamp(damping / range, 0.0, 1.0) : 0.0;
  const auto kd = static_cast<std::uint32_t>(share * kDampingSteps);
  frame.put({0x7f, 0xff, 0x7f, 0xff, 0, 0, static_cast<std::uint8_t>(kd >> 8), static_cast<std::uint8_t>(kd & 0xffu)});
  return frame;
}

DriveFrame encode(const DriveAxis& axis, const DriveCommand& command) noexcept {
  switch (command.action) {
    case DriveAction::kPoll:
      return robstride_read(axis.id, RobStrideParameter::kPosition);
    case DriveAction::kEnable:
      return plain(kEnable, axis.id, 0);
    case DriveAction::kTorque:
      return control(axis, command.torque_Nm, command.damping_Nms_per_rad);
    case DriveAction::kBrake:
      return control(axis, 0, axis.brake_damping_Nms_per_rad);
    case DriveAction::kDisable:
      return plain(kStop, axis.id, 0);
    case DriveAction::kClear:
      break;
  }
  return plain(kStop, axis.id, 1);
}

DriveDecode decode_control(const DriveAxis& axis, const DriveFrame& frame, DriveAnswer& answer) noexcept {
  answer.has_position = answer.has_mode = true;
  answer.position_rad = middle_value(be16_at(frame, 0), axis.position_range_rad);
  answer.speed_rad_per_s = middle_value(be16_at(frame, 2), axis.speed_range_rad_per_s);
  answer.torque_Nm = middle_value(be16_at(frame, 4), axis.torque_range_Nm);
  answer.fault = frame.id >> 16 & kFaultBits;
  const std::uint32_t mode = frame.id >> 22 & 3u;
  answer.mode = answer.fault != 0 ? DriveMode::kFaulted : mode == 2 ? DriveMode::kEnabled : DriveMode::kDisabled;
  return DriveDecode::kAnswer;
}

DriveDecode decode(const DriveAxis& axis, const DriveFrame& frame, DriveAnswer& answer) noexcept {
  const std::uint32_t type = frame.id >> 24;
  const bool ours = frame.extended && (type == kAnswer || type == kRead) && (frame.id & 0xffu) == kRobStrideHost &&
                    (frame.id >> 8 & 0xffu) == axis.id;
  if (!ours) return DriveDecode::kForeign;
  if (frame.size != 8) return DriveDecode::kMalformed;
  if (type == kAnswer) return decode_control(axis, frame, answer);
  std::uint32_t value = 0;
  bool known = false;
  if (!parse_robstride_parameter(axis, RobStrideParameter::kPosition, frame, value, known))
    return DriveDecode::kForeign;
  const auto position = static_cast<double>(std::bit_cast<float>(value));
  if (!known || !std::isfinite(position)) return DriveDecode::kMalformed;
  answer.has_position = true;
  answer.position_rad = position;
  return DriveDecode::kAnswer;
}

}  // namespace

const DriveCodec kRobStrideCodec{.name = "robstride",
                                 .encode = encode,
                                 .decode = decode,
                                 .command_bytes = 8,
                                 .answer_bytes = 8,
                                 .extended_command = true,
                                 .extended_answer = true,
                                 .needs_fd = false,
                                 .damps = true,
                                 .tells_enabled = true,
                                 .has_float_position = false,
                                 .default_damping_range_Nms_per_rad = 5,
                                 .damping_steps = kDampingSteps};

DriveFrame robstride_ask_id(unsigned motor_id) noexcept { return plain(kAskId, motor_id, 0); }

DriveFrame robstride_read(unsigned motor_id, RobStrideParameter index) noexcept {
  DriveFrame frame = frame_of(kRead, kRobStrideHost, motor_id);
  const auto number = static_cast<std::uint16_t>(index);
  frame.put({static_cast<std::uint8_t>(number & 0xffu), static_cast<std::uint8_t>(number >> 8), 0, 0, 0, 0, 0, 0});
  return frame;
}

DriveFrame robstride_write(unsigned motor_id, RobStrideParameter index, std::uint32_t value) noexcept {
  DriveFrame frame = frame_of(kWrite, kRobStrideHost, motor_id);
  const auto number = static_cast<std::uint16_t>(index);
  frame.put({static_cast<std::uint8_t>(number & 0xffu), static_cast<std::uint8_t>(number >> 8), 0, 0});
  frame.put_u32(value);
  return frame;
}

bool parse_robstride_parameter(const DriveAxis& axis, RobStrideParameter index, const DriveFrame& frame,
                               std::uint32_t& value, bool& known) noexcept {
  const bool ours = frame.extended && frame.id >> 24 == kRead && (frame.id & 0xffu) == kRobStrideHost &&
                    (frame.id >> 8 & 0xffu) == axis.id && frame.size == 8 &&
                    u16_at(frame, 0) == static_cast<std::uint16_t>(index);
  if (!ours) return false;
  known = (frame.id >> 16 & 0xffu) == 0;
  value = u32_at(frame, 4);
  return true;
}

bool parse_robstride_id(const DriveAxis& axis, const DriveFrame& frame, std::uint64_t& chip) noexcept {
  const bool ours = frame.extended && frame.id >> 24 == kAskId && (frame.id >> 8 & 0xffu) == axis.id && frame.size == 8;
  if (ours) chip = u32_at(frame, 0) | static_cast<std::uint64_t>(u32_at(frame, 4)) << 32;
  return ours;
}

}  // namespace tactus::hal
