// An arm whose axes are CAN drives: a HapticDevice on one or two buses (drive_bus.h), any kinematics, any family.
//
// One period: read() takes the answers to the commands of the last write(); a complete set of answers is a fresh
// sample. write() computes the efforts and sends one command per drive, back to back. A drive answers at once, so the
// smallest transport delay is one tick.
//   IDLE   the drives are disabled and polled      FORCE  torque, and damping in the drive
//   BRAKE  no torque, brake damping, as long as this process runs; then the drives' own watchdogs act
// While a drive takes some periods to enable (moteus), the arm reports FORCE without torque, until all are enabled. A
// drive that was enabled and then reports another mode brakes the arm.
// When write() is not called: from the third period on the last efforts fade, with the tenth the arm brakes (fault 1).
// When the process dies: the drives hold the last torque until their watchdog, at most 10 ms; therefore efforts are
// limited in slope (DriveDescription::full_effort_s).
// A drive that answers and does not make the commanded torque brakes the arm (torque_watch.h), if the answers of its
// family contain the torque.
// Faults that the arm reports itself, latched until a re-arm: 1, 4 (firmware/faults.h), and those of drive_faults.h.
// Thread: construction, start() [setup]; read(), write() [rt]: no allocation, no lock, no wait; at most kMaxFrames
// frames per bus and period, the rest waits for the next. Frame: the device's. Units: SI.
#pragma once

#include <array>

#include "hal/drives/drive_bus.h"
#include "hal/drives/drive_codec.h"
#include "hal/drives/torque_watch.h"
#include "hal/host_states.h"
#include "hal/profiles.h"

namespace tactus::hal {

// Since start(). Every read is counted in exactly one of the first four.
struct DriveArmCounters {
  std::uint64_t fresh{0}, missing{0}, corrupt{0}, disconnected{0};
  std::uint64_t foreign{0}, malformed{0}, repeated{0};  // frames; repeated: a second answer in one period
  std::uint64_t not_sent{0};                            // commands that a bus did not take
};

class DriveArm {
 public:
  static constexpr unsigned kMaxFrames = 64;

  // `buses`: one for each of the description's, with prepared drives (drive_setup.h). Precondition:
  // find_drive_mistake(profile) reports none.
  DriveArm(const DeviceProfile& profile, std::int64_t period_ns, DriveBuses buses);
  ~DriveArm();  // disables the drives, without torque
  DriveArm(const DriveArm&) = delete;
  DriveArm& operator=(const DriveArm&) = delete;

  // Drops waiting frames and requests a first sample from the drives.
  Status start();

  const haptics::DeviceProperties& properties() const noexcept { return properties_; }
  void read(haptics::DeviceInput& input) noexcept;
  void write(const haptics::DeviceCommand& command) noexcept;

  const DriveArmCounters& counters() const noexcept { return counters_; }
  // The code of the drive's family that the axis reported last; 0: none.
  std::uint32_t drive_code(unsigned axis) const noexcept { return axes_[axis].answer.fault; }

 private:
  enum class Step : std::uint8_t { kIdle, kEnabling, kForce, kBraking, kClearing, kLeaving };

  struct Axis {
    DriveAnswer answer;
    bool answered{false};        // in this period
    unsigned silent_periods{0};  // in a row
    double effort{0};            // the last one sent
    TorqueWatch torque;
  };

  void drain(unsigned bus) noexcept;
  void take(unsigned bus, const ReceivedDriveFrame& received) noexcept;
  haptics::ReadStatus status_of_period() noexcept;
  void watch_drives() noexcept;
  void watch_enabling() noexcept;
  bool lacks_torque(unsigned axis) noexcept;
  void watch_commands() noexcept;
  void choose_step() noexcept;
  void send_step(double share) noexcept;
  void send_all(DriveAction action, const AxisVector& effort) noexcept;
  void brake(std::uint32_t fault) noexcept;
  void brake_drives() noexcept;
  AxisVector coordinates() const noexcept;

  DriveDescription drives_;
  const DriveCodec* codec_;
  Kinematics kinematics_;
  haptics::DeviceProperties properties_;
  AxisVector max_effort_{}, max_slope_{};  // N or N m; per period
  std::int64_t period_ns_;
  DriveBuses buses_;
  std::array<Axis, kAxisCount> axes_{};
  unsigned count_;
  haptics::DeviceSample sample_;
  HostStates states_{haptics::DeviceState::kReset};
  AxisVector q_{};
  Step step_{Step::kIdle};
  unsigned enabling_periods_{0}, longest_start_;  // periods
  std::uint64_t periods_{0};
  bool malformed_{false}, to_disable_{false};
  DriveArmCounters counters_;
};

static_assert(haptics::HapticDevice<DriveArm>);

}  // namespace tactus::hal
