#include "hal/drives/odrive_codec.h"

#include <algorithm>
#include <cmath>

namespace tactus::hal {
namespace {

DriveFrame to(unsigned node, OdriveCommand command) noexcept {
  return {.id = node << 5 | static_cast<std::uint32_t>(command)};
}

DriveFrame axis_state(unsigned node, std::uint32_t state) noexcept {
  DriveFrame frame = to(node, OdriveCommand::kAxisState);
  frame.put_u32(state);
  return frame;
}

DriveFrame torque(const DriveAxis& axis, double torque_Nm) noexcept {
  DriveFrame frame = to(axis.id, OdriveCommand::kInputTorque);
  const double finite = std::isfinite(torque_Nm) ? torque_Nm : 0.0;
  frame.put_f32(static_cast<float>(std::clamp(finite, -axis.torque_range_Nm, axis.torque_range_Nm)));
  return frame;
}

DriveFrame encode(const DriveAxis& axis, const DriveCommand& command) noexcept {
  switch (command.action) {
    case DriveAction::kPoll:
      return {};
    case DriveAction::kEnable:
      return axis_state(axis.id, kOdriveClosedLoop);
    case DriveAction::kTorque:
      return torque(axis, command.torque_Nm);
    case DriveAction::kBrake:
      return torque(axis, 0);
    case DriveAction::kDisable:
      return axis_state(axis.id, kOdriveIdle);
    case DriveAction::kClear:
      break;
  }
  DriveFrame frame = to(axis.id, OdriveCommand::kClearErrors);
  frame.put({0, 0, 0, 0, 0, 0, 0, 0});
  return frame;
}

DriveDecode decode(const DriveAxis& axis, const DriveFrame& frame, DriveAnswer& answer) noexcept {
  std::uint32_t error = 0, state = 0;
  const std::uint32_t estimates = axis.id << 5 | static_cast<std::uint32_t>(OdriveCommand::kEstimates);
  const std::uint32_t heartbeat = axis.id << 5 | static_cast<std::uint32_t>(OdriveCommand::kHeartbeat);
  if (frame.extended || (frame.id != estimates && frame.id != heartbeat)) return DriveDecode::kForeign;
  if (frame.size != 8) return DriveDecode::kMalformed;
  if (parse_odrive_heartbeat(axis, frame, error, state)) {
    answer.has_mode = true;
    answer.fault = error;
    answer.mode = error != 0                   ? DriveMode::kFaulted
                  : state == kOdriveClosedLoop ? DriveMode::kEnabled
                                               : DriveMode::kDisabled;
    return DriveDecode::kAnswer;
  }
  const auto turns = static_cast<double>(f32_at(frame, 0)), turns_per_s = static_cast<double>(f32_at(frame, 4));
  if (!std::isfinite(turns) || !std::isfinite(turns_per_s)) return DriveDecode::kMalformed;
  answer.has_position = true;
  answer.position_rad = turns * kTurn_rad;
  answer.speed_rad_per_s = turns_per_s * kTurn_rad;
  return DriveDecode::kAnswer;
}

}  // namespace

const DriveCodec kOdriveCodec{.name = "odrive",
                              .encode = encode,
                              .decode = decode,
                              .command_bytes = 4,
                              .answer_bytes = 8,
                              .extended_command = false,
                              .extended_answer = false,
                              .needs_fd = false,
                              .damps = false,
                              .tells_enabled = false,
                              .has_float_position = true,
                              .default_damping_range_Nms_per_rad = 0,
                              .damping_steps = 0,
                              .tells_torque = false};

DriveFrame odrive_torque_mode(unsigned node) noexcept {
  DriveFrame frame = to(node, OdriveCommand::kControllerMode);
  frame.put_u32(1);
  frame.put_u32(1);
  return frame;
}

bool parse_odrive_heartbeat(const DriveAxis& axis, const DriveFrame& frame, std::uint32_t& error,
                            std::uint32_t& state) noexcept {
  const std::uint32_t id = axis.id << 5 | static_cast<std::uint32_t>(OdriveCommand::kHeartbeat);
  if (frame.extended || frame.id != id || frame.size != 8) return false;
  error = u32_at(frame, 0);
  state = frame.data[4];
  return true;
}

}  // namespace tactus::hal
