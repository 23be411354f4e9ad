// The simulated drives of an arm without its mechanics: what frames do to them, faults by script, and their answers,
// which stay queued on their bus until they are read.
//
// Its owner moves the shafts: simulated_drives.h in one process; another process where each drive has a process of its
// own (tests/vm/drive_processes.h). Thread: construction, inject(), restart_clock() [setup]; the rest
// [rt], by one thread: no allocation, no lock, bounded. Units: SI, of the drives' reported shafts.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "hal/drives/drive_bus.h"
#include "hal/drives/simulated_drive.h"
#include "hal/kinematics/tool_kinematics.h"

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
  kRestarted = 9,    // the drive restarts in the first tick, and receives nothing before the last
  kWrapped = 10,     // the position has jumped by twice its range
  kSpeed = 11,       // the speed field is at its end
  kBusOff = 12,      // the whole bus is off
};

inline constexpr unsigned kAllAxes = std::numeric_limits<unsigned>::max();

struct DriveFault {
  DriveFaultKind kind{DriveFaultKind::kNoAnswer};
  unsigned axis{kAllAxes};
  std::uint64_t tick{0}, ticks{1};  // counted from 0 by restart_clock()
};

using DriveShafts = std::array<DriveShaft, kAxisCount>;

class SimulatedRack {
 public:
  static constexpr unsigned kMaxFaults = 16;

  SimulatedRack(const DriveDescription& description, std::int64_t period_ns);

  // The other drives neither receive nor send.
  void keep_only(unsigned axis) noexcept { only_ = axis; }

  // One period: begin_period(), then pass() for each step in which the owner moves the shafts, then end_period().
  void begin_period() noexcept;
  void pass(unsigned axis, double time_s) noexcept { drives_[axis].advance(time_s); }
  void end_period(const DriveShafts& shafts) noexcept;

  void hear(unsigned bus, const DriveFrame& frame, const DriveShafts& shafts) noexcept;
  // Takes an answer that is due. False: none is.
  bool fetch(unsigned bus, ReceivedDriveFrame& received) noexcept;

  // Sets the tick of faults to 0 and drops waiting frames.
  void restart_clock() noexcept;
  // Precondition: fewer than kMaxFaults that are not over.
  void inject(const DriveFault& fault) noexcept;
  bool acts(DriveFaultKind kind, unsigned axis) const noexcept;

  SimulatedDrive& drive(unsigned axis) noexcept { return drives_[axis]; }
  const SimulatedDrive& drive(unsigned axis) const noexcept { return drives_[axis]; }
  unsigned size() const noexcept { return static_cast<unsigned>(drives_.size()); }
  std::uint64_t tick() const noexcept { return tick_; }
  std::int64_t now_ns() const noexcept { return now_ns_; }

 private:
  struct Mail {
    ReceivedDriveFrame received;
    std::uint64_t from_tick{0};  // due from this tick on
  };
  // First in, first out; a full queue drops the newest, as a kernel's does.
  struct Queue {
    std::array<Mail, 128> mails;
    unsigned first{0}, size{0};
  };

  bool is_here(unsigned axis) const noexcept { return only_ == kAllAxes || only_ == axis; }
  void post(unsigned axis, const DriveFrame& frame) noexcept;
  void put(unsigned bus, const Mail& mail) noexcept;

  DriveDescription description_;
  std::int64_t period_ns_, now_ns_{0};
  std::vector<SimulatedDrive> drives_;
  std::array<Queue, kMaxBuses> queues_{};
  std::array<DriveFault, kMaxFaults> faults_{};
  unsigned fault_count_{0}, only_{kAllAxes};
  std::uint64_t tick_{0};
};

}  // namespace tactus::hal
