// An arm whose drives have a process each, as real drives have a processor each; the mechanics that couples them is in
// this one.
//
// Each drive's process has a socket of its own on its bus, hears what is sent to its drive and answers for it alone.
// What it shares with this process is the shaft between them, in memory that both see: this one tells where the shaft
// is and how fast, the drive what torque it makes of its last command (hal::DriveLaw); both exchange whole values, once
// a period and after each command, and neither waits. The periods of all begin together; the mechanics moves a quarter
// of one later. A drive's process ends with this one.
// Thread: construction [setup], the rest by one thread.
#pragma once

#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <new>

#include "rt/base/clock.h"
#include "rt/base/latest_value.h"
#include "tests/vm/drive_peer.h"

namespace tactus::vm {

struct DriveReport {
  hal::DriveLaw law;
  std::uint64_t silent_periods{0};  // its own, since its last command
  std::uint32_t not_sent{0}, lost{0};
};

struct SharedDrive {
  LatestValue<hal::DriveShaft> shaft;  // from the mechanics
  LatestValue<hal::DriveFault> ordered;
  LatestValue<DriveReport> report;  // from the drive
  std::atomic<bool> ready{false};
};

// What a controller hands to the drive: frames with its identifier, and a Damiao's registers, which have one for all.
inline std::vector<can_filter> filters_of(hal::DriveFamily family, unsigned id) {
  constexpr canid_t kKind = CAN_EFF_FLAG | CAN_RTR_FLAG;
  switch (family) {
    case hal::DriveFamily::kRobStride:
      return {{CAN_EFF_FLAG | id, kKind | 0xffu}};
    case hal::DriveFamily::kMoteus:
      return {{CAN_EFF_FLAG | id, kKind | 0x7fffu}};
    case hal::DriveFamily::kOdrive:
      return {{id << 5, kKind | 0x7e0u}};
    default:
      return {{id, kKind | CAN_SFF_MASK}, {0x7ff, kKind | CAN_SFF_MASK}};
  }
}

// The drive of one axis, in its own process: a World for DrivePeer.
class LoneDrive {
 public:
  LoneDrive(const hal::DriveDescription& drives, unsigned axis, std::int64_t period_ns, SharedDrive& shared)
      : rack_(drives, period_ns),
        axis_(axis),
        buses_(static_cast<unsigned>(drives.buses.size())),
        step_s_(1e-9 * static_cast<double>(period_ns) / hal::ArmMechanics::kSubSteps),
        shared_(shared) {
    rack_.keep_only(axis);
  }

  unsigned buses() const noexcept { return buses_; }
  void hear(unsigned bus, const hal::DriveFrame& frame) noexcept {
    if (rack_.drive(axis_).is_meant_by(frame)) report_.silent_periods = 0;
    rack_.hear(bus, frame, shafts());
    tell();
  }
  bool fetch(unsigned bus, hal::ReceivedDriveFrame& answer) noexcept { return rack_.fetch(bus, answer); }
  void advance() noexcept {
    if (const hal::DriveFault* ordered = shared_.ordered.take(); ordered != nullptr) {
      hal::DriveFault fault = *ordered;
      fault.tick = rack_.tick();
      rack_.inject(fault);
    }
    rack_.begin_period();
    for (unsigned i = 0; i < hal::ArmMechanics::kSubSteps; ++i) rack_.pass(axis_, step_s_);
    rack_.end_period(shafts());
    ++report_.silent_periods;
    tell();
  }
  void count(unsigned not_sent, std::uint32_t lost) noexcept {
    report_.not_sent = not_sent;
    report_.lost = lost;
  }

 private:
  const hal::DriveShafts& shafts() noexcept {
    if (const hal::DriveShaft* shaft = shared_.shaft.take(); shaft != nullptr) shafts_[axis_] = *shaft;
    return shafts_;
  }
  void tell() noexcept {
    report_.law = rack_.drive(axis_).law();
    shared_.report.writing() = report_;
    shared_.report.publish();
  }

  hal::SimulatedRack rack_;
  unsigned axis_, buses_;
  double step_s_;  // of the watchdog
  SharedDrive& shared_;
  hal::DriveShafts shafts_{};
  DriveReport report_;
};

class DriveProcesses {
 public:
  DriveProcesses(const hal::DeviceProfile& profile, const hal::HandModel& hand, std::uint32_t period_us,
                 const std::vector<std::string>& interfaces, int priority)
      : drives_(profile.description.drives),
        period_ns_(std::int64_t{period_us} * 1000),
        mechanics_(profile, hand, period_ns_) {
    if (interfaces.size() != drives_.buses.size()) fail("accepted: one interface per bus of the description");
    constexpr int kShared = MAP_SHARED | MAP_ANONYMOUS;
    void* const memory = mmap(nullptr, sizeof(Shared), PROT_READ | PROT_WRITE, kShared, -1, 0);
    if (memory == MAP_FAILED) fail("no shared memory");
    shared_ = new (memory) Shared;
    tell_shafts();  // before the drives look
    for (unsigned axis = 0; axis < drives_.axes.size(); ++axis) start(axis, interfaces, priority);
    for (unsigned axis = 0; axis < drives_.axes.size(); ++axis) await(axis);
    deadline_ns_ = firmware::now_ns() / period_ns_ * period_ns_ + period_ns_ / 4;
  }
  ~DriveProcesses() {
    for (const pid_t process : processes_) kill(process, SIGKILL);
    for (const pid_t process : processes_) (void)waitpid(process, nullptr, 0);
  }
  DriveProcesses(const DriveProcesses&) = delete;
  DriveProcesses& operator=(const DriveProcesses&) = delete;

  void run_period() {
    MonotonicClock::sleep_until_ns(deadline_ns_ += period_ns_);
    for (unsigned axis = 0; axis < drives_.axes.size(); ++axis) {
      if (const DriveReport* report = (*shared_)[axis].report.take(); report != nullptr) reports_[axis] = *report;
    }
    mechanics_.advance([this](unsigned axis, double speed_rad_per_s, double) noexcept {
      return reports_[axis].law.at(drives_.axes[axis], speed_rad_per_s);
    });
    tell_shafts();
    ++periods_;
  }

  std::uint64_t periods() const noexcept { return periods_; }
  std::uint64_t silent_periods() const noexcept {
    std::uint64_t least = reports_[0].silent_periods;
    for (unsigned axis = 1; axis < drives_.axes.size(); ++axis) least = std::min(least, reports_[axis].silent_periods);
    return least;
  }
  unsigned not_sent() const noexcept {
    unsigned sum = 0;
    for (const DriveReport& report : reports_) sum += report.not_sent;
    return sum;
  }
  std::uint32_t lost() const noexcept {
    std::uint32_t sum = 0;
    for (const DriveReport& report : reports_) sum += report.lost;
    return sum;
  }
  hal::DriveLaw law(unsigned axis) noexcept { return reports_[axis].law; }
  void restart_hand() noexcept { mechanics_.restart_clock(); }
  const hal::Plant& plant() const noexcept { return mechanics_.plant(); }
  // From the next period of each drive on.
  void inject(const hal::DriveFault& fault) noexcept {
    for (unsigned axis = 0; axis < drives_.axes.size(); ++axis) {
      if (fault.axis != hal::kAllAxes && fault.axis != axis) continue;
      (*shared_)[axis].ordered.writing() = fault;
      (*shared_)[axis].ordered.publish();
    }
  }

 private:
  using Shared = std::array<SharedDrive, hal::kAxisCount>;

  void tell_shafts() noexcept {
    const hal::DriveShafts shafts = mechanics_.shafts();
    for (unsigned axis = 0; axis < drives_.axes.size(); ++axis) {
      (*shared_)[axis].shaft.writing() = shafts[axis];
      (*shared_)[axis].shaft.publish();
    }
  }

  void start(unsigned axis, std::vector<std::string> interfaces, int priority) {
    const pid_t parent = getpid(), process = fork();
    if (process < 0) fail("no process for a drive");
    if (process > 0) {
      processes_.push_back(process);
      return;
    }
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(2);
    for (unsigned bus = 0; bus < interfaces.size(); ++bus)
      if (bus != drives_.axes[axis].bus) interfaces[bus].clear();
    LoneDrive drive(drives_, axis, period_ns_, (*shared_)[axis]);
    DrivePeer<LoneDrive> peer(drive, static_cast<std::uint32_t>(period_ns_ / 1000), interfaces,
                              drives_.data_bit_per_s != 0, filters_of(drives_.family, drives_.axes[axis].id));
    if (const std::string refused = firmware::make_realtime(priority, -1); !refused.empty()) fail(refused);
    (*shared_)[axis].ready.store(true);
    for (;;) {
      peer.run_period();
      drive.count(peer.not_sent(), peer.lost());
    }
  }

  // Until the drive of this axis listens.
  void await(unsigned axis) {
    while (!(*shared_)[axis].ready.load()) {
      if (waitpid(processes_[axis], nullptr, WNOHANG) != 0) fail("the process of a drive has ended");
      MonotonicClock::sleep_until_ns(MonotonicClock::now_ns() + 1'000'000);
    }
  }

  hal::DriveDescription drives_;
  std::int64_t period_ns_, deadline_ns_{0};
  hal::ArmMechanics mechanics_;
  Shared* shared_{nullptr};
  std::vector<pid_t> processes_;
  std::array<DriveReport, hal::kAxisCount> reports_{};
  std::uint64_t periods_{0};
};

}  // namespace tactus::vm
