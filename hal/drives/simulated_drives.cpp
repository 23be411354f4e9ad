#include "hal/drives/simulated_drives.h"

#include <fmt/format.h>

#include "hal/drives/drive_setup.h"

namespace tactus::hal {
namespace {

// One of the buses; the drives' world must outlive it.
class SimulatedBus final : public DriveBus {
 public:
  SimulatedBus(SimulatedDrives& world, unsigned bus) : world_(world), bus_(bus) {}
  bool receive(ReceivedDriveFrame& received) noexcept override { return world_.fetch(bus_, received); }
  bool send(const DriveFrame& frame) noexcept override {
    if (!connected()) return false;
    world_.hear(bus_, frame);
    return true;
  }
  bool connected() const noexcept override { return !world_.acts(DriveFaultKind::kBusOff, bus_); }
  std::int64_t now_ns() const noexcept override { return world_.now_ns(); }
  void wait(std::chrono::nanoseconds) override { world_.advance(); }

 private:
  SimulatedDrives& world_;
  unsigned bus_;
};

}  // namespace

DriveBuses SimulatedDrives::make_buses() {
  DriveBuses buses;
  for (unsigned bus = 0; bus < buses_; ++bus) buses.push_back(std::make_unique<SimulatedBus>(*this, bus));
  return buses;
}

void SimulatedDrives::restart_clock() noexcept {
  rack_.restart_clock();
  mechanics_.restart_clock();
}

void SimulatedDrives::advance() noexcept {
  rack_.begin_period();
  mechanics_.advance([this](unsigned axis, double speed_rad_per_s, double time_s) noexcept {
    const double torque_Nm = rack_.drive(axis).torque_Nm(speed_rad_per_s);
    rack_.pass(axis, time_s);
    return torque_Nm;
  });
  rack_.end_period(mechanics_.shafts());
}

Wrenchd SimulatedDrives::commanded_wrench() const noexcept {
  AxisVector torques_Nm{};
  for (unsigned i = 0; i < rack_.size(); ++i) torques_Nm[i] = rack_.drive(i).commanded_Nm();
  return mechanics_.wrench_of(torques_Nm);
}

Result<std::unique_ptr<SimulatedDriveArm>> SimulatedDriveArm::open(const DeviceProfile& profile, const HandModel& hand,
                                                                   std::int64_t period_ns) {
  std::unique_ptr<SimulatedDriveArm> made(new SimulatedDriveArm(profile, hand, period_ns));
  made->world_.hold_hand();  // the drives are prepared for as long as a second
  DriveBuses buses = made->world_.make_buses();
  auto prepared = prepare_drives(profile.description.drives, buses);
  if (!prepared.ok()) return prepared.status();
  made->identity_ = fmt::format("{}", fmt::join(prepared.value(), ", "));
  made->arm_ = std::make_unique<DriveArm>(profile, period_ns, std::move(buses));
  made->world_.restart_clock();
  if (Status status = made->arm_->start(); !status.ok()) return status;
  return made;
}

}  // namespace tactus::hal
