#include "hal/drives/moteus_codec.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace tactus::hal {
namespace {

constexpr std::uint8_t kNothing = 0x50, kWriteI8 = 0x00, kWriteI16 = 0x04, kWriteF32 = 0x0c, kReadI8 = 0x10,
                       kReadI32 = 0x18, kReadF32 = 0x1c, kReply = 0x20;
constexpr std::uint8_t kTorque = 0x22, kKpScale = 0x23, kTimeout = 0x27, kPosition = 0x20, kFault = 0x0f;
constexpr double kMoteusScaleSteps = 32767;
// Text through the bus: sub-frame, channel, length, letters.
constexpr std::uint8_t kTextToDrive = 0x40, kTextFromDrive = 0x41, kPollText = 0x42, kConsole = 1, kMostText = 48;
constexpr std::uint32_t kAnswerWanted = 0x8000;

// Source 0 is the host.
DriveFrame to(unsigned id) noexcept { return {.id = kAnswerWanted | (id & 0x7fu), .extended = true, .fd = true}; }

void pad(DriveFrame& frame) noexcept {
  constexpr std::uint8_t kLengths[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64};
  const std::uint8_t length = *std::lower_bound(std::begin(kLengths), std::end(kLengths), frame.size);
  while (frame.size < length) frame.put({kNothing});
}

DriveFrame with_query(DriveFrame frame) noexcept {
  frame.put({kReadI8 + 1, 0x00, kReadF32 + 3, 0x01, kReadI8 + 1, kFault});
  pad(frame);
  return frame;
}

DriveFrame mode(unsigned id, std::uint8_t number) noexcept {
  DriveFrame frame = to(id);
  frame.put({kWriteI8 + 1, 0x00, number});
  return with_query(frame);
}

DriveFrame control(const DriveAxis& axis, double torque_Nm, double damping) noexcept {
  const double range = axis.damping_range_Nms_per_rad;
  const double share = std::isfinite(damping) && range > 0 ? std::clamp(damping / range, 0.0, 1.0) : 0.0;
  const double torque = std::isfinite(torque_Nm) ? torque_Nm : 0.0;
  DriveFrame frame = to(axis.id);
  frame.put({kWriteI8 + 1, 0x00, kMoteusPosition, kWriteI8 + 1, kPosition, 0x80, kWriteF32 + 1, kTorque});
  frame.put_f32(static_cast<float>(std::clamp(torque, -axis.torque_range_Nm, axis.torque_range_Nm)));
  // 16 bits: with 8 a small damping would be rounded to nothing.
  const auto kd = static_cast<std::uint32_t>(share * kMoteusScaleSteps);
  frame.put({kWriteI16 + 2, kKpScale, 0, 0, static_cast<std::uint8_t>(kd & 0xffu), static_cast<std::uint8_t>(kd >> 8),
             kWriteI16 + 1, kTimeout, kMoteusTimeout_ms, 0});
  return with_query(frame);
}

DriveFrame encode(const DriveAxis& axis, const DriveCommand& command) noexcept {
  switch (command.action) {
    case DriveAction::kPoll:
      return with_query(to(axis.id));
    case DriveAction::kEnable:
      return control(axis, 0, 0);
    case DriveAction::kTorque:
      return control(axis, command.torque_Nm, command.damping_Nms_per_rad);
    case DriveAction::kBrake:
      return mode(axis.id, kMoteusBrake);
    default:  // mode 0 disables, and clears faults
      return mode(axis.id, kMoteusStopped);
  }
}

bool is_from(const DriveAxis& axis, const DriveFrame& frame) noexcept {
  const std::uint32_t id = axis.id << 8;
  return frame.extended == (id >= 0x800u) && (frame.id & 0x7fffu) == id && frame.id <= 0x7fffu;
}

// One value of a reply, as a number in its register's unit; not used for i16 and i32 of registers with a scale.
struct Reader {
  const DriveFrame& frame;
  unsigned at{0};

  bool has(unsigned bytes) const noexcept { return at + bytes <= frame.size; }
  bool varuint(std::uint32_t& value) noexcept {
    value = 0;
    for (unsigned shift = 0; shift < 28; shift += 7) {
      if (!has(1)) return false;
      const std::uint8_t byte = frame.data[at++];
      value |= static_cast<std::uint32_t>(byte & 0x7f) << shift;
      if ((byte & 0x80) == 0) return true;
    }
    return false;
  }
};

constexpr unsigned kSizes[] = {1, 2, 4, 4};

// Calls `value(register, type, offset)` for each value of the replies in the frame. False: the frame is malformed.
template <class F>
bool for_each_reply(const DriveFrame& frame, F&& value) noexcept {
  Reader reader{frame};
  while (reader.at < frame.size) {
    const std::uint8_t head = frame.data[reader.at++];
    if (head == kNothing) continue;
    if (head < kReply || head > kReply + 0xf) return false;  // errors 0x30 and 0x31, too
    const unsigned type = (head >> 2) & 3u;
    std::uint32_t count = head & 3u, number = 0;
    if (count == 0 && !reader.varuint(count)) return false;
    if (!reader.varuint(number)) return false;
    for (std::uint32_t i = 0; i < count; ++i) {
      if (!reader.has(kSizes[type])) return false;
      value(number + i, type, reader.at);
      reader.at += kSizes[type];
    }
  }
  return true;
}

DriveMode mode_of(int number) noexcept {
  if (number == kMoteusFault) return DriveMode::kFaulted;
  if (number == kMoteusTimedOut) return DriveMode::kTimedOut;
  if (number == kMoteusStopped) return DriveMode::kDisabled;
  if (number >= kMoteusFirstStart && number <= kMoteusLastStart) return DriveMode::kStarting;
  return number == kMoteusPosition ? DriveMode::kEnabled : DriveMode::kOther;
}

struct Values {
  float position_turn{0}, velocity_turn_per_s{0}, torque_Nm{0};
  int mode{-1}, fault{0};
  unsigned seen{0};  // bit of each of the five
};

void take(const DriveFrame& frame, std::uint32_t number, unsigned type, unsigned at, Values& values) noexcept {
  if (type == 3 && number >= 1 && number <= 3) {
    (number == 1   ? values.position_turn
     : number == 2 ? values.velocity_turn_per_s
                   : values.torque_Nm) = f32_at(frame, at);
    values.seen |= 1u << number;
  } else if (type == 0 && (number == 0 || number == kFault)) {
    (number == 0 ? values.mode : values.fault) = static_cast<std::int8_t>(frame.data[at]);
    values.seen |= number == 0 ? 1u : 0x10u;
  }
}

DriveDecode decode(const DriveAxis& axis, const DriveFrame& frame, DriveAnswer& answer) noexcept {
  if (!is_from(axis, frame)) return DriveDecode::kForeign;
  Values values;
  const bool whole = for_each_reply(
      frame, [&](std::uint32_t number, unsigned type, unsigned at) { take(frame, number, type, at, values); });
  const auto finite = [](float x) { return std::isfinite(static_cast<double>(x)); };
  if (!whole) return DriveDecode::kMalformed;
  if (values.seen == 0) return DriveDecode::kForeign;  // the answer to another query
  if (values.seen != 0x1f || !finite(values.position_turn) || !finite(values.velocity_turn_per_s) ||
      !finite(values.torque_Nm))
    return DriveDecode::kMalformed;
  answer.has_position = answer.has_mode = true;
  answer.position_rad = static_cast<double>(values.position_turn) * kTurn_rad;
  answer.speed_rad_per_s = static_cast<double>(values.velocity_turn_per_s) * kTurn_rad;
  answer.torque_Nm = static_cast<double>(values.torque_Nm);
  answer.mode = mode_of(values.mode);
  // Codes from 96 on report which limit acts; they are not faults.
  answer.fault = answer.mode == DriveMode::kFaulted ? static_cast<std::uint32_t>(std::max(values.fault, 1)) : 0;
  return DriveDecode::kAnswer;
}

}  // namespace

const DriveCodec kMoteusCodec{.name = "moteus",
                              .encode = encode,
                              .decode = decode,
                              .command_bytes = 32,
                              .answer_bytes = 20,
                              .extended_command = true,
                              .extended_answer = false,
                              .needs_fd = true,
                              .damps = true,
                              .tells_enabled = true,
                              .has_float_position = true,
                              .default_damping_range_Nms_per_rad = 0,
                              .damping_steps = kMoteusScaleSteps};

DriveFrame moteus_read(unsigned id, MoteusRegister first, unsigned count) noexcept {
  DriveFrame frame = to(id);
  const auto number = static_cast<std::uint16_t>(first);
  frame.put({static_cast<std::uint8_t>(kReadI32 + count)});
  if (number < 0x80)
    frame.put({static_cast<std::uint8_t>(number)});
  else
    frame.put({static_cast<std::uint8_t>(0x80u | (number & 0x7fu)), static_cast<std::uint8_t>(number >> 7)});
  pad(frame);
  return frame;
}

bool parse_moteus_register(const DriveAxis& axis, MoteusRegister number, const DriveFrame& frame,
                           std::int32_t& value) noexcept {
  if (!is_from(axis, frame)) return false;
  bool found = false;
  for_each_reply(frame, [&](std::uint32_t seen, unsigned type, unsigned at) {
    if (type != 2 || seen != static_cast<std::uint32_t>(number)) return;
    value = static_cast<std::int32_t>(u32_at(frame, at));
    found = true;
  });
  return found;
}

DriveFrame moteus_ask_configuration(unsigned id, std::string_view key) noexcept {
  constexpr std::string_view kGet = "conf get ";
  constexpr std::size_t kLongestKey = 32;
  key = key.substr(0, kLongestKey);
  DriveFrame frame = to(id);
  frame.id &= ~kAnswerWanted;
  frame.put({kTextToDrive, kConsole, static_cast<std::uint8_t>(kGet.size() + key.size() + 1)});
  for (const std::string_view part : {kGet, key, std::string_view("\n")})
    for (const char letter : part) frame.put({static_cast<std::uint8_t>(letter)});
  pad(frame);
  return frame;
}

DriveFrame moteus_poll_text(unsigned id) noexcept {
  DriveFrame frame = to(id);
  frame.put({kPollText, kConsole, kMostText});
  return frame;
}

bool take_moteus_text(const DriveAxis& axis, const DriveFrame& frame, std::string& text) {
  if (!is_from(axis, frame) || frame.size < 3 || frame.data[0] != kTextFromDrive || frame.data[1] != kConsole)
    return false;
  const unsigned size = std::min<unsigned>(frame.data[2], frame.size - 3u);
  for (unsigned i = 0; i < size; ++i) text += static_cast<char>(frame.data[3 + i]);
  return true;
}

}  // namespace tactus::hal
