#include "hal/drives/mit_codec.h"

#include <cmath>

namespace tactus::hal {
namespace {

constexpr std::uint8_t kEnable = 0xfc, kDisable = 0xfd, kClearFault = 0xfb;
constexpr std::uint8_t kRead = 0x33, kWrite = 0x55, kStore = 0xaa;
constexpr unsigned kPositionBits = 16, kFieldBits = 12;
constexpr double kDampingSteps = 4095, kDampingRange = 5;  // N m s/rad, of the 12-bit field of all these drives

DriveFrame special(const DriveAxis& axis, std::uint8_t code) noexcept {
  DriveFrame frame{.id = axis.id};
  frame.put({0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, code});
  return frame;
}

DriveFrame control(const DriveAxis& axis, double torque_Nm, double damping, bool round_up) noexcept {
  const std::uint32_t p = field_of(0, axis.position_range_rad, kPositionBits, round_up);
  const std::uint32_t v = field_of(0, axis.speed_range_rad_per_s, kFieldBits, round_up);
  const double share = std::isfinite(damping) ? std::min(std::max(damping / kDampingRange, 0.0), 1.0) : 0.0;
  const auto kd = static_cast<std::uint32_t>(share * kDampingSteps);
  const std::uint32_t t = field_of(torque_Nm, axis.torque_range_Nm, kFieldBits, round_up);
  DriveFrame frame{.id = axis.id};
  const auto byte = [](std::uint32_t value) { return static_cast<std::uint8_t>(value & 0xffu); };
  frame.put({byte(p >> 8), byte(p), byte(v >> 4), byte(v << 4), 0, byte(kd >> 4), byte(kd << 4 | t >> 8), byte(t)});
  return frame;
}

DriveFrame encode(const DriveAxis& axis, const DriveCommand& command) noexcept {
  switch (command.action) {
    case DriveAction::kEnable:
      return special(axis, kEnable);
    case DriveAction::kDisable:
      return special(axis, kDisable);
    case DriveAction::kTorque:
      return control(axis, command.torque_Nm, command.damping_Nms_per_rad, command.round_up);
    case DriveAction::kBrake:
      return control(axis, 0, axis.brake_damping_Nms_per_rad, command.round_up);
    default:  // kPoll: a command of zeros; a disabled drive answers it and stores it
      return control(axis, 0, 0, command.round_up);
  }
}

DriveFrame encode_damiao(const DriveAxis& axis, const DriveCommand& command) noexcept {
  return command.action == DriveAction::kClear ? special(axis, kClearFault) : encode(axis, command);
}

void read_fields(const DriveAxis& axis, const DriveFrame& frame, DriveAnswer& answer) noexcept {
  const std::uint32_t v = static_cast<std::uint32_t>(frame.data[3] << 4 | frame.data[4] >> 4);
  const std::uint32_t t = static_cast<std::uint32_t>((frame.data[4] & 0xf) << 8 | frame.data[5]);
  answer.has_position = true;
  answer.position_rad = value_of_field(be16_at(frame, 1), axis.position_range_rad, kPositionBits);
  answer.speed_rad_per_s = value_of_field(v, axis.speed_range_rad_per_s, kFieldBits);
  answer.torque_Nm = value_of_field(t, axis.torque_range_Nm, kFieldBits);
}

bool on_answer_id(const DriveAxis& axis, const DriveFrame& frame) noexcept {
  return !frame.extended && frame.id == axis.answer_id;
}

DriveDecode decode_damiao(const DriveAxis& axis, const DriveFrame& frame, DriveAnswer& answer) noexcept {
  if (!on_answer_id(axis, frame)) return DriveDecode::kForeign;
  if (frame.size != 8) return DriveDecode::kMalformed;
  // The answer to a register request has the same identifier. Its third byte would be the low byte of a position at
  // the very end of the range, where a described joint never is.
  const bool is_register =
      frame.data[1] == 0 && (frame.data[2] == kRead || frame.data[2] == kWrite || frame.data[2] == kStore);
  if (is_register) return DriveDecode::kForeign;
  if ((frame.data[0] & 0xfu) != (axis.id & 0xfu)) return DriveDecode::kForeign;
  read_fields(axis, frame, answer);
  const std::uint32_t status = frame.data[0] >> 4;
  answer.has_mode = true;
  answer.fault = status >= 8 ? status : 0;
  answer.mode = status == 0                 ? DriveMode::kDisabled
                : status == 1               ? DriveMode::kEnabled
                : status == kDamiaoHostLost ? DriveMode::kTimedOut
                                            : DriveMode::kFaulted;
  return DriveDecode::kAnswer;
}

DriveDecode decode_plain(const DriveAxis& axis, const DriveFrame& frame, DriveAnswer& answer) noexcept {
  if (!on_answer_id(axis, frame)) return DriveDecode::kForeign;
  if (frame.size < 6 || frame.size > 8) return DriveDecode::kMalformed;
  if (frame.data[0] != (axis.id & 0xffu)) return DriveDecode::kForeign;
  read_fields(axis, frame, answer);
  return DriveDecode::kAnswer;
}

DriveDecode decode_cube_mars(const DriveAxis& axis, const DriveFrame& frame, DriveAnswer& answer) noexcept {
  if (const DriveDecode decoded = decode_plain(axis, frame, answer); decoded != DriveDecode::kAnswer) return decoded;
  if (frame.size != 8) return DriveDecode::kMalformed;
  answer.fault = frame.data[7];
  if (answer.fault != 0) {
    answer.has_mode = true;
    answer.mode = DriveMode::kFaulted;
  }
  return DriveDecode::kAnswer;
}

constexpr DriveCodec of(std::string_view name, decltype(DriveCodec::encode) encode_function,
                        decltype(DriveCodec::decode) decode_function, bool tells_enabled) noexcept {
  return {.name = name,
          .encode = encode_function,
          .decode = decode_function,
          .command_bytes = 8,
          .answer_bytes = 8,
          .extended_command = false,
          .extended_answer = false,
          .needs_fd = false,
          .damps = true,
          .tells_enabled = tells_enabled,
          .has_float_position = false,
          .default_damping_range_Nms_per_rad = kDampingRange,
          .damping_steps = kDampingSteps};
}

DriveFrame register_frame(unsigned motor_id, std::uint8_t operation, DamiaoRegister number,
                          std::uint32_t value) noexcept {
  DriveFrame frame{.id = kDamiaoRegisterId};
  frame.put({static_cast<std::uint8_t>(motor_id), static_cast<std::uint8_t>(motor_id >> 8), operation,
             static_cast<std::uint8_t>(number)});
  frame.put_u32(value);
  return frame;
}

}  // namespace

const DriveCodec kDamiaoCodec = of("damiao", encode_damiao, decode_damiao, true);
const DriveCodec kCubeMarsCodec = of("cubemars", encode, decode_cube_mars, false);
const DriveCodec kMiniCheetahCodec = of("mini_cheetah", encode, decode_plain, false);

DriveFrame damiao_read(unsigned motor_id, DamiaoRegister number) noexcept {
  return register_frame(motor_id, kRead, number, 0);
}

DriveFrame damiao_write(unsigned motor_id, DamiaoRegister number, std::uint32_t value) noexcept {
  return register_frame(motor_id, kWrite, number, value);
}

bool parse_damiao_register(const DriveAxis& axis, DamiaoRegister number, const DriveFrame& frame,
                           std::uint32_t& value) noexcept {
  const bool ours = on_answer_id(axis, frame) && frame.size == 8 && u16_at(frame, 0) == axis.id &&
                    (frame.data[2] == kRead || frame.data[2] == kWrite) &&
                    frame.data[3] == static_cast<std::uint8_t>(number);
  if (ours) value = u32_at(frame, 4);
  return ours;
}

}  // namespace tactus::hal
