#include "hal/drives/simulated_drive.h"

#include <algorithm>
#include <cmath>
#include <string_view>

namespace tactus::hal {
namespace {

// From stopped to position mode; the last part of it in mode 2.
constexpr double kMoteusStart_s = 0.012, kMoteusGateDriver_s = 0.002;
constexpr double kOdriveTimeout_s = 0.01, kEstimateEvery_s = 0.001, kHeartbeatEvery_s = 0.1;

std::uint32_t pack(double value, double range, double top) noexcept {
  return static_cast<std::uint32_t>(std::clamp(std::floor((value + range) / (2 * range) * top), 0.0, top));
}

bool is_special(const DriveFrame& frame) noexcept {
  return std::all_of(frame.data.begin(), frame.data.begin() + 7, [](std::uint8_t byte) { return byte == 0xff; });
}

}  // namespace

SimulatedDrive::SimulatedDrive(DriveFamily family, const DriveAxis& axis) noexcept
    : family_(family), axis_(axis), start_s_(kMoteusStart_s) {
  restart();
}

void SimulatedDrive::restart() noexcept {
  disable();
  fault_ = 0;
  control_mode_ = 2;
  // After a restart Damiao and RobStride have no watchdog; the others keep a configured one.
  timeout_s_ = family_ == DriveFamily::kDamiao || family_ == DriveFamily::kRobStride ? 0.0 : kOdriveTimeout_s;
}

void SimulatedDrive::disable() noexcept {
  enabled_ = braked_ = timed_out_ = false;
  torque_ = damping_ = starts_in_s_ = 0;
}

void SimulatedDrive::report_fault(std::uint32_t code) noexcept {
  disable();
  fault_ = code;
}

double DriveLaw::at(const DriveAxis& axis, double speed_rad_per_s) const noexcept {
  if (braked) return -axis.brake_damping_Nms_per_rad * speed_rad_per_s;
  if (!enabled) return 0;
  const double torque = torque_Nm - damping_Nms_per_rad * speed_rad_per_s;
  return std::clamp(torque, -axis.torque_range_Nm, axis.torque_range_Nm);
}

bool SimulatedDrive::is_meant_by(const DriveFrame& frame) const noexcept {
  switch (family_) {
    case DriveFamily::kRobStride:
      return frame.extended && (frame.id & 0xffu) == axis_.id;
    case DriveFamily::kMoteus:
      return frame.extended && (frame.id & 0x7fffu) == axis_.id;
    case DriveFamily::kOdrive:
      return !frame.extended && frame.id >> 5 == axis_.id;
    default:
      return !frame.extended && (frame.id == axis_.id || (family_ == DriveFamily::kDamiao && frame.id == 0x7ff &&
                                                          frame.size >= 2 && u16_at(frame, 0) == axis_.id));
  }
}

void SimulatedDrive::advance(double time_s) noexcept {
  silent_s_ += time_s;
  estimate_due_s_ -= time_s;
  heartbeat_due_s_ -= time_s;
  if (starts_in_s_ > 0) {
    starts_in_s_ -= time_s;
    enabled_ = starts_in_s_ <= 0;
  }
  if (!enabled_ || !watchdog_works_ || timeout_s_ <= 0 || silent_s_ < timeout_s_) return;
  disable();
  timed_out_ = true;
  braked_ = family_ == DriveFamily::kMoteus;
  if (family_ == DriveFamily::kDamiao) fault_ = 0xd;
  if (family_ == DriveFamily::kOdrive) fault_ = 0x800;
}

double SimulatedDrive::seen_position(const DriveShaft& shaft) const noexcept {
  const double position = shaft.position_rad + wrapped_by_;
  if (axis_.counts_per_turn <= 0) return position;
  const double quantum = kTurn_rad / axis_.counts_per_turn;
  return std::floor(position / quantum) * quantum;
}

double SimulatedDrive::seen_speed(const DriveShaft& shaft) const noexcept {
  return speed_saturates_ ? 1e6 : shaft.speed_rad_per_s;
}

bool SimulatedDrive::hear(const DriveFrame& frame, const DriveShaft& shaft, DriveFrame& reply) noexcept {
  switch (family_) {
    case DriveFamily::kRobStride:
      return hear_robstride(frame, shaft, reply);
    case DriveFamily::kMoteus:
      return hear_moteus(frame, shaft, reply);
    case DriveFamily::kOdrive:
      hear_odrive(frame);
      return false;
    default:
      return hear_mit(frame, shaft, reply);
  }
}

// --- MIT

DriveFrame SimulatedDrive::mit_answer(const DriveShaft& shaft) const noexcept {
  const std::uint32_t p = pack(seen_position(shaft), axis_.position_range_rad, 65535);
  const std::uint32_t v = pack(seen_speed(shaft), axis_.speed_range_rad_per_s, 4095);
  const std::uint32_t t = pack(torque_Nm(shaft.speed_rad_per_s), axis_.torque_range_Nm, 4095);
  const std::uint32_t status = fault_ != 0 ? fault_ : enabled_ ? 1u : 0u;
  const bool damiao = family_ == DriveFamily::kDamiao;
  DriveFrame frame{.id = axis_.answer_id};
  const auto byte = [](std::uint32_t value) { return static_cast<std::uint8_t>(value & 0xffu); };
  frame.put({byte(damiao ? status << 4 | (axis_.id & 0xfu) : axis_.id), byte(p >> 8), byte(p), byte(v >> 4),
             byte((v & 0xfu) << 4 | t >> 8), byte(t)});
  if (damiao) frame.put({35, 30});
  if (family_ == DriveFamily::kCubeMars) frame.put({35, byte(fault_)});
  return frame;
}

bool SimulatedDrive::hear_mit(const DriveFrame& frame, const DriveShaft& shaft, DriveFrame& reply) noexcept {
  if (frame.extended || frame.size != 8) return false;
  if (family_ == DriveFamily::kDamiao && frame.id == 0x7ff) return hear_damiao_register(frame, reply);
  if (frame.id != axis_.id) return false;
  silent_s_ = 0;
  reply = mit_answer(shaft);  // of the state before the command
  if (is_special(frame)) {
    if (frame.data[7] == 0xfb) fault_ = 0;
    if (frame.data[7] == 0xfc && fault_ == 0) enabled_ = true;
    if (frame.data[7] == 0xfd) enabled_ = timed_out_ = false;
    reply = mit_answer(shaft);
    return true;
  }
  if (!enabled_) return true;
  if (family_ == DriveFamily::kDamiao && control_mode_ != 1) {  // another mode misreads the frame
    torque_ = axis_.torque_range_Nm;
    return true;
  }
  const std::uint32_t kd = static_cast<std::uint32_t>(frame.data[5] << 4 | frame.data[6] >> 4);
  const std::uint32_t t = static_cast<std::uint32_t>((frame.data[6] & 0xf) << 8 | frame.data[7]);
  damping_ = kd * 5.0 / 4095;
  torque_ = t * 2 * axis_.torque_range_Nm / 4095 - axis_.torque_range_Nm;
  return true;
}

bool SimulatedDrive::hear_damiao_register(const DriveFrame& frame, DriveFrame& reply) noexcept {
  if (u16_at(frame, 0) != axis_.id) return false;
  silent_s_ = 0;
  const bool writes = frame.data[2] == 0x55;
  const std::uint8_t number = frame.data[3];
  if (writes && number == 9) timeout_s_ = u32_at(frame, 4) * 50e-6;
  if (writes && number == 10) control_mode_ = u32_at(frame, 4);
  reply = {.id = axis_.answer_id};
  reply.put({frame.data[0], frame.data[1], frame.data[2], number});
  const auto f32 = [&reply](double value) { reply.put_f32(static_cast<float>(value)); };
  if (number == 7)
    reply.put_u32(axis_.answer_id);
  else if (number == 8)
    reply.put_u32(axis_.id);
  else if (number == 9)
    reply.put_u32(static_cast<std::uint32_t>(std::lround(timeout_s_ / 50e-6)));
  else if (number == 10)
    reply.put_u32(control_mode_);
  else if (number == 21)
    f32(axis_.position_range_rad);
  else if (number == 22)
    f32(axis_.speed_range_rad_per_s);
  else if (number == 23)
    f32(axis_.torque_range_Nm);
  else
    reply.put_u32(0);
  return true;
}

// --- RobStride

DriveFrame SimulatedDrive::robstride_answer(const DriveShaft& shaft) const noexcept {
  const auto field = [](double value, double range) {
    return static_cast<std::uint32_t>(std::clamp(std::floor((value / range + 1) * 0x7fff), 0.0, 65534.0));
  };
  const std::uint32_t mode = enabled_ ? 2u : 0u;
  DriveFrame frame{.id = 0x02000000u | mode << 22 | (fault_ & 0x3fu) << 16 | axis_.id << 8 | 0xfdu, .extended = true};
  for (const std::uint32_t value :
       {field(seen_position(shaft), axis_.position_range_rad), field(seen_speed(shaft), axis_.speed_range_rad_per_s),
        field(torque_Nm(shaft.speed_rad_per_s), axis_.torque_range_Nm), 300u})
    frame.put({static_cast<std::uint8_t>(value >> 8), static_cast<std::uint8_t>(value & 0xffu)});
  return frame;
}

bool SimulatedDrive::hear_robstride(const DriveFrame& frame, const DriveShaft& shaft, DriveFrame& reply) noexcept {
  if (!frame.extended || frame.size != 8 || (frame.id & 0xffu) != axis_.id) return false;
  const std::uint32_t type = frame.id >> 24, index = u16_at(frame, 0);
  silent_s_ = 0;
  if (type == 1 && enabled_) {
    torque_ = ((frame.id >> 8 & 0xffffu) / 32767.0 - 1) * axis_.torque_range_Nm;
    damping_ = be16_at(frame, 6) * axis_.damping_range_Nms_per_rad / 65535;
  }
  if (type == 3 && fault_ == 0) {
    enabled_ = true;
    timed_out_ = false;
  }
  if (type == 4) {
    disable();
    if (frame.data[0] == 1) fault_ = 0;
  }
  if (type == 18 && index == 0x7028) timeout_s_ = u32_at(frame, 4) * 50e-6;
  if (type == 18 && index == 0x7005) control_mode_ = frame.data[4];
  reply = robstride_answer(shaft);
  if (type == 0) {
    reply = {.id = axis_.id << 8 | 0xfeu, .extended = true};
    reply.put_u32(0x1000u + axis_.id);
    reply.put_u32(serial_);
  } else if (type == 17) {
    const bool known = index == 0x7005 || index == 0x700b || index == 0x7019 || index == 0x7028;
    reply = {.id = 17u << 24 | (known ? 0u : 1u) << 16 | axis_.id << 8 | 0xfdu, .extended = true};
    reply.put({frame.data[0], frame.data[1], 0, 0});
    if (index == 0x7005)
      reply.put_u32(control_mode_);
    else if (index == 0x700b)
      reply.put_f32(static_cast<float>(axis_.torque_range_Nm));
    else if (index == 0x7019)
      reply.put_f32(static_cast<float>(seen_position(shaft)));
    else if (index == 0x7028)
      reply.put_u32(static_cast<std::uint32_t>(std::lround(timeout_s_ / 50e-6)));
    else
      reply.put_u32(0);
  }
  return true;
}

// --- moteus: the sub-frames that the host sends, not the whole grammar

// The text console. Of its commands, only the one that reads servo.timeout_mode is simulated.
bool SimulatedDrive::hear_moteus_text(const DriveFrame& frame, DriveFrame& reply) noexcept {
  constexpr std::string_view kQuestion = "conf get servo.timeout_mode\n";
  if (frame.data[0] == 0x40) {
    text_waits_ = frame.data[1] == 1 && frame.data[2] == kQuestion.size() &&
                  std::equal(kQuestion.begin(), kQuestion.end(), frame.data.begin() + 3,
                             [](char a, std::uint8_t b) { return static_cast<std::uint8_t>(a) == b; });
    return false;
  }
  if (frame.data[0] != 0x42) return false;
  const auto digit = [](unsigned value) { return static_cast<std::uint8_t>('0' + value % 10); };
  reply.put({0x41, 1, static_cast<std::uint8_t>(text_waits_ ? 4 : 0)});
  if (text_waits_) reply.put({digit(timeout_mode_ / 10), digit(timeout_mode_), '\r', '\n'});
  text_waits_ = false;
  return true;
}

bool SimulatedDrive::hear_moteus(const DriveFrame& frame, const DriveShaft& shaft, DriveFrame& reply) noexcept {
  if (!frame.extended || (frame.id & 0x7fffu) != axis_.id) return false;
  const std::uint32_t id = axis_.id << 8;
  reply = {.id = id, .extended = id >= 0x800u, .fd = true};
  if (frame.data[0] >= 0x40 && frame.data[0] <= 0x42) return hear_moteus_text(frame, reply);
  if (frame.id != (0x8000u | axis_.id)) return false;
  if (frame.size >= 3 && frame.data[0] == 0x19) {  // one register as i32
    const std::uint32_t number =
        frame.data[1] < 0x80 ? frame.data[1] : (frame.data[1] & 0x7fu) | std::uint32_t{frame.data[2]} << 7;
    reply.put({0x29, frame.data[1]});
    if (frame.data[1] >= 0x80) reply.put({frame.data[2]});
    reply.put_u32(number == 0x102   ? 5u
                  : number == 0x101 ? 0x10au
                  : number == 0x120 ? 0x5e0000u + axis_.id
                  : number == 0x121 ? serial_
                                    : 1u);
    return true;
  }
  if (frame.size == 2 && frame.data[0] == 0x19) {
    reply.put({0x29, frame.data[1]});
    reply.put_u32(frame.data[1] == 0x0c ? 2u : 0u);
    return true;
  }
  reply = moteus_answer(reply, shaft);  // of the state before the command
  if (frame.size >= 3 && frame.data[0] == 0x01 && frame.data[1] == 0x00) take_moteus_mode(frame);
  return true;
}

DriveFrame SimulatedDrive::moteus_answer(DriveFrame reply, const DriveShaft& shaft) const noexcept {
  const bool calibrates = starts_in_s_ > 0 && starts_in_s_ <= start_s_ - kMoteusGateDriver_s;
  const std::uint8_t mode = fault_ != 0        ? 1
                            : timed_out_       ? 11
                            : calibrates       ? 3
                            : starts_in_s_ > 0 ? 2
                            : braked_          ? 15
                            : enabled_         ? 10
                                               : 0;
  reply.put({0x21, 0x00, mode, 0x2f, 0x01});
  reply.put_f32(static_cast<float>(seen_position(shaft) / kTurn_rad));
  reply.put_f32(static_cast<float>(seen_speed(shaft) / kTurn_rad));
  reply.put_f32(static_cast<float>(torque_Nm(shaft.speed_rad_per_s)));
  reply.put({0x21, 0x0f, static_cast<std::uint8_t>(fault_)});
  return reply;
}

// Only mode 0 ends a fault or a time-out; the change from there to position mode takes start_s_.
void SimulatedDrive::take_moteus_mode(const DriveFrame& frame) noexcept {
  const std::uint8_t mode = frame.data[2];
  silent_s_ = 0;
  if (mode == 0) {
    disable();
    fault_ = 0;
  } else if (fault_ != 0 || timed_out_) {
    return;
  } else if (mode == 15) {
    disable();
    braked_ = true;
  } else if (mode == 10) {
    if (!enabled_ && !braked_ && starts_in_s_ <= 0) starts_in_s_ = start_s_;
    enabled_ = enabled_ || braked_;  // between two modes with current the change is immediate
    braked_ = false;
    torque_ = static_cast<double>(f32_at(frame, 8));
    damping_ = u16_at(frame, 16) / 32767.0 * axis_.damping_range_Nms_per_rad;
    timeout_s_ = u16_at(frame, 20) * 1e-3;
  }
}

// --- ODrive

void SimulatedDrive::hear_odrive(const DriveFrame& frame) noexcept {
  if (frame.extended || frame.id >> 5 != axis_.id) return;
  const std::uint32_t command = frame.id & 0x1fu;
  silent_s_ = 0;
  if (command == 0x18) fault_ = 0;
  if (command == 0x07 && frame.size >= 4) {
    const std::uint32_t state = u32_at(frame, 0);
    if (state == 8 && fault_ == 0) enabled_ = true;
    if (state == 1) disable();
  }
  if (command == 0x0e && frame.size >= 4 && enabled_) torque_ = static_cast<double>(f32_at(frame, 0));
}

bool SimulatedDrive::send_cyclic(const DriveShaft& shaft, DriveFrame& frame) noexcept {
  if (family_ != DriveFamily::kOdrive) return false;
  if (estimate_due_s_ <= 1e-9) {
    estimate_due_s_ += kEstimateEvery_s;
    frame = {.id = axis_.id << 5 | 0x09u};
    frame.put_f32(static_cast<float>(seen_position(shaft) / kTurn_rad));
    frame.put_f32(static_cast<float>(seen_speed(shaft) / kTurn_rad));
    return true;
  }
  if (heartbeat_due_s_ > 1e-9) return false;
  heartbeat_due_s_ += kHeartbeatEvery_s;
  frame = {.id = axis_.id << 5 | 0x01u};
  frame.put_u32(fault_);
  frame.put({static_cast<std::uint8_t>(enabled_ ? 8 : 1), 0, 0, 0});
  return true;
}

}  // namespace tactus::hal
