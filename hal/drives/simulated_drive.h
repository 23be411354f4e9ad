// One simulated drive: what a drive of the family does with the frames that reach it, quanta and watchdog included.
//
// Written from the families' documents (mit_codec.h and its neighbours name them), independent of the host's codec
// where a byte is decoded or encoded twice. Thread: the owner's; no allocation but by the set-up requests' answers.
// Units: SI, of the drive's reported shaft.
#pragma once

#include <array>
#include <span>

#include "hal/drives/drive_axis.h"
#include "hal/drives/drive_frame.h"

namespace tactus::hal {

// The shaft as the drive measures it now.
struct DriveShaft {
  double position_rad{0}, speed_rad_per_s{0};
};

// The torque law that the last command set; it holds until the next command.
struct DriveLaw {
  bool enabled{false}, braked{false};
  double torque_Nm{0}, damping_Nms_per_rad{0};

  // Torque [N m] on the shaft of this axis at this speed.
  double at(const DriveAxis& axis, double speed_rad_per_s) const noexcept;
  // The commanded part of the torque, without the damping.
  double commanded_Nm() const noexcept { return enabled ? torque_Nm : 0; }
};

class SimulatedDrive {
 public:
  SimulatedDrive(DriveFamily family, const DriveAxis& axis) noexcept;

  // A frame from the bus. True: `reply` holds the drive's answer.
  bool hear(const DriveFrame& frame, const DriveShaft& shaft, DriveFrame& reply) noexcept;
  // advance(): lets time_s pass, for the watchdog. send_cyclic(), ODrive only: true when an estimate (first) or a
  // heartbeat (then) is to be sent now.
  void advance(double time_s) noexcept;
  bool send_cyclic(const DriveShaft& shaft, DriveFrame& frame) noexcept;

  DriveLaw law() const noexcept {
    return {.enabled = enabled_, .braked = braked_, .torque_Nm = torque_, .damping_Nms_per_rad = damping_};
  }
  // N m on the shaft at this speed.
  double torque_Nm(double speed_rad_per_s) const noexcept { return law().at(axis_, speed_rad_per_s); }
  double commanded_Nm() const noexcept { return law().commanded_Nm(); }
  bool enabled() const noexcept { return enabled_; }
  // True for a command to this drive; false for answers and for commands to other drives.
  bool is_meant_by(const DriveFrame& frame) const noexcept;

  // --- faults by command
  void report_fault(std::uint32_t code) noexcept;  // of the family; it is disabled
  void disable() noexcept;                         // by itself, without a fault
  void restart() noexcept;                         // as after a power failure: values written into its RAM are lost
  void keep_no_watchdog() noexcept { watchdog_works_ = false; }
  void set_watchdog(double time_s) noexcept { timeout_s_ = time_s; }       // ODrive, as by its maker's tool
  void set_timeout_mode(unsigned mode) noexcept { timeout_mode_ = mode; }  // moteus
  void set_start(double time_s) noexcept { start_s_ = time_s; }            // moteus, from stopped to position mode
  void set_serial(std::uint32_t serial) noexcept { serial_ = serial; }     // RobStride, moteus: another drive
  void wrap_position(double by_rad) noexcept { wrapped_by_ = by_rad; }
  void saturate_speed(bool on) noexcept { speed_saturates_ = on; }

 private:
  bool hear_mit(const DriveFrame& frame, const DriveShaft& shaft, DriveFrame& reply) noexcept;
  bool hear_damiao_register(const DriveFrame& frame, DriveFrame& reply) noexcept;
  bool hear_robstride(const DriveFrame& frame, const DriveShaft& shaft, DriveFrame& reply) noexcept;
  bool hear_moteus_text(const DriveFrame& frame, DriveFrame& reply) noexcept;
  bool hear_moteus(const DriveFrame& frame, const DriveShaft& shaft, DriveFrame& reply) noexcept;
  void hear_odrive(const DriveFrame& frame) noexcept;
  DriveFrame mit_answer(const DriveShaft& shaft) const noexcept;
  DriveFrame robstride_answer(const DriveShaft& shaft) const noexcept;
  double seen_position(const DriveShaft& shaft) const noexcept;
  double seen_speed(const DriveShaft& shaft) const noexcept;

  DriveFamily family_;
  DriveAxis axis_;
  DriveFrame moteus_answer(DriveFrame reply, const DriveShaft& shaft) const noexcept;
  void take_moteus_mode(const DriveFrame& frame) noexcept;

  bool enabled_{false}, braked_{false}, timed_out_{false}, watchdog_works_{true}, speed_saturates_{false};
  std::uint32_t fault_{0};
  double torque_{0}, damping_{0}, wrapped_by_{0};
  double timeout_s_{0}, silent_s_{0};  // timeout 0: off
  std::uint32_t control_mode_{2};      // as a Damiao may come from its maker: not MIT
  unsigned timeout_mode_{15};
  double start_s_, starts_in_s_{0};  // moteus: time to reach position mode, and the rest of it; 0: it is not starting
  std::uint32_t serial_{0xabcd0000u};
  bool text_waits_{false};  // of a moteus' console
  double estimate_due_s_{0}, heartbeat_due_s_{0};
};

}  // namespace tactus::hal
