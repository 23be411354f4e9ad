// An arm of drives without hardware: the mechanics of the described arm with a hand, one simulated drive per axis, and
// buses to them in this process. For tests, and for `--device drives-sim`.
//
// Time passes by advance() and, while the drives are prepared, by DriveBus::wait(). A command is answered at once; the
// answer waits for the next receive(), as on a bus. Thread: construction [setup]; the rest [rt], by one thread: no
// allocation, no lock, bounded. Frame: the device's. Units: SI. Deterministic.
#pragma once

#include "hal/drives/arm_mechanics.h"
#include "hal/drives/drive_arm.h"
#include "hal/drives/simulated_rack.h"
#include "rt/base/result.h"

namespace tactus::hal {

class SimulatedDrives {
 public:
  static constexpr unsigned kMaxFaults = SimulatedRack::kMaxFaults;

  SimulatedDrives(const DeviceProfile& profile, const HandModel& hand, std::int64_t period_ns)
      : rack_(profile.description.drives, period_ns),
        mechanics_(profile, hand, period_ns),
        buses_(static_cast<unsigned>(profile.description.drives.buses.size())) {}

  // Buses to these drives, which must outlive them.
  DriveBuses make_buses();
  unsigned buses() const noexcept { return buses_; }

  // One period passes.
  void advance() noexcept;
  // A frame that is sent on a bus, and an answer that is taken from it.
  void hear(unsigned bus, const DriveFrame& frame) noexcept { rack_.hear(bus, frame, mechanics_.shafts()); }
  bool fetch(unsigned bus, ReceivedDriveFrame& received) noexcept { return rack_.fetch(bus, received); }

  // [setup] Starts the hand's path, sets the tick of faults to 0 and drops frames that wait on the buses.
  void restart_clock() noexcept;
  // [setup] The hand stays at the start of its path until restart_clock().
  void hold_hand() noexcept { mechanics_.hold_hand(); }
  // [setup] Precondition: fewer than kMaxFaults that are not over.
  void inject(const DriveFault& fault) noexcept { rack_.inject(fault); }
  bool acts(DriveFaultKind kind, unsigned axis) const noexcept { return rack_.acts(kind, axis); }

  const Plant& plant() const noexcept { return mechanics_.plant(); }
  SimulatedDrive& drive(unsigned axis) noexcept { return rack_.drive(axis); }
  // The wrench at the tool that the drives' commanded torques cause, without damping.
  Wrenchd commanded_wrench() const noexcept;
  std::uint64_t tick() const noexcept { return rack_.tick(); }
  std::int64_t now_ns() const noexcept { return rack_.now_ns(); }

 private:
  SimulatedRack rack_;
  ArmMechanics mechanics_;
  unsigned buses_;
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
