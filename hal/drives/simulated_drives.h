// An arm of drives without hardware: the plant of the described arm, a hand, one simulated drive per axis, and buses to
// them in this process. For tests, and for `--device drives-sim`.
//
// Time passes by advance() and, while the drives are prepared, by DriveBus::wait(). A command is answered at once; the
// answer waits for the next receive(), as on a bus. Thread: construction [setup]; the rest [rt], by one thread: no
// allocation, no lock, bounded. Frame: the device's. Units: SI. Deterministic.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "hal/drives/drive_arm.h"
#include "hal/drives/simulated_drive.h"
#include "hal/hand.h"
#include "hal/plant.h"
#include "rt/base/result.h"

namespace tactus::hal {

enum class DriveFaultKind : std::uint8_t {
  kNoAnswer = 0,     // the drive does not answer
  kNoCommand = 1,    // the command does not reach the drive
  kLate = 2,         // the answer comes one period late
  kTwice = 3,        // two answers
  kForeignId = 4,    // the answer has another drive's identifier
  kUndefinedId = 5,  // the answer has an identifier that no drive has
  kShort = 6,        // the answer lacks its last three bytes
  kFaultFlag = 7,    // the drive reports a fault of its own, from the first tick on
  kDisabled = 8,     // the drive disables itself in the first tick
  kRestarted = 9,    // the drive restarts in the first tick, and hears nothing before the last
  kWrapped = 10,     // the position has jumped by twice its range
  kSpeed = 11,       // the speed field is at its end
  kBusOff = 12,      // the whole bus is off
};

inline constexpr unsigned kAllAxes = std::numeric_limits<unsigned>::max();

struct DriveFault {
  DriveFaultKind kind{DriveFaultKind::kNoAnswer};
  unsigned axis{kAllAxes};
  std::uint64_t tick{0}, ticks{1};  // of advance(), counted from 0 by restart_clock()
};

class SimulatedDrives {
 public:
  static constexpr unsigned kSubSteps = 16;  // of the mechanics per period: the drives close their damping in each
  static constexpr unsigned kMaxFaults = 16;

  SimulatedDrives(const DeviceProfile& profile, const HandModel& hand, std::int64_t period_ns);

  // Buses to these drives, which must outlive them.
  DriveBuses make_buses();

  // One period passes.
  void advance() noexcept;
  // [setup] The hand's path and the ticks of faults begin now; what waits on the buses is gone.
  void restart_clock() noexcept;
  // [setup] While it is held, the hand stays where its path begins; restart_clock() lets it go.
  void hold_hand() noexcept { hand_held_ = true; }
  // [setup] Precondition: fewer than kMaxFaults that are not over.
  void inject(const DriveFault& fault) noexcept;

  const Plant& plant() const noexcept { return plant_; }
  SimulatedDrive& drive(unsigned axis) noexcept { return drives_[axis]; }
  // What the drives' commanded torques make at the tool, damping left out.
  Wrenchd commanded_wrench() const noexcept;
  std::uint64_t tick() const noexcept { return tick_; }

 private:
  friend class SimulatedBus;
  struct Mail {
    ReceivedDriveFrame received;
    std::uint64_t from_tick{0};  // it is there from this tick on
  };
  // First in, first out; a full queue drops the newest, as a kernel's does.
  struct Queue {
    std::array<Mail, 128> mails;
    unsigned first{0}, size{0};
  };

  void hear(unsigned bus, const DriveFrame& frame) noexcept;
  void post(unsigned axis, const DriveFrame& frame) noexcept;
  bool fetch(unsigned bus, ReceivedDriveFrame& received) noexcept;
  void put(unsigned bus, const Mail& mail) noexcept;
  void sub_step(double into_s) noexcept;  // of the period
  void begin_faults() noexcept;
  bool acts(DriveFaultKind kind, unsigned axis) const noexcept;
  DriveShaft shaft_of(unsigned axis, const AxisVector& rate) const noexcept;
  AxisVector rates() const noexcept { return kinematics_.rates_of(plant_.coordinates(), plant_.twist()); }

  DriveDescription description_;
  Kinematics kinematics_;
  HandModel hand_;
  Plant plant_;
  std::int64_t period_ns_, now_ns_{0};
  std::vector<SimulatedDrive> drives_;
  std::array<Queue, kMaxBuses> queues_{};
  std::array<DriveFault, kMaxFaults> faults_{};
  unsigned fault_count_{0};
  std::uint64_t tick_{0};
  bool hand_held_{false};
};

// The arm on them, as one device: one read() is one period.
class SimulatedDriveArm {
 public:
  // [setup] Prepares the drives as on a bus. Error as of prepare_drives.
  static Result<std::unique_ptr<SimulatedDriveArm>> open(const DeviceProfile& profile, const HandModel& hand,
                                                         std::int64_t period_ns);

  const haptics::DeviceProperties& properties() const noexcept { return arm_->properties(); }
  void read(haptics::DeviceInput& input) noexcept {
    world_.advance();
    arm_->read(input);
  }
  void write(const haptics::DeviceCommand& command) noexcept { arm_->write(command); }

  SimulatedDrives& world() noexcept { return world_; }
  DriveArm& arm() noexcept { return *arm_; }
  const std::string& identity() const noexcept { return identity_; }

 private:
  SimulatedDriveArm(const DeviceProfile& profile, const HandModel& hand, std::int64_t period_ns)
      : world_(profile, hand, period_ns) {}

  SimulatedDrives world_;
  std::unique_ptr<DriveArm> arm_;  // after the world, which it uses until its end
  std::string identity_;
};

static_assert(haptics::HapticDevice<SimulatedDriveArm>);

}  // namespace tactus::hal
