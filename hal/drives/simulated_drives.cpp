#include "hal/drives/simulated_drives.h"

#include <fmt/format.h>

#include <algorithm>

#include "hal/drives/drive_setup.h"

namespace tactus::hal {

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
  std::int64_t now_ns() const noexcept override { return world_.now_ns_; }
  void wait(std::chrono::nanoseconds) override { world_.advance(); }

 private:
  SimulatedDrives& world_;
  unsigned bus_;
};

SimulatedDrives::SimulatedDrives(const DeviceProfile& profile, const HandModel& hand, std::int64_t period_ns)
    : description_(profile.description.drives),
      kinematics_(profile.kinematics),
      hand_(hand),
      plant_(profile.plant, hand.parameters(), hand.target_at(0.0).pose, profile.kinematics),
      period_ns_(period_ns) {
  for (const DriveAxis& axis : description_.axes) drives_.emplace_back(description_.family, axis);
}

DriveBuses SimulatedDrives::make_buses() {
  DriveBuses buses;
  for (unsigned bus = 0; bus < description_.buses.size(); ++bus)
    buses.push_back(std::make_unique<SimulatedBus>(*this, bus));
  return buses;
}

void SimulatedDrives::restart_clock() noexcept {
  tick_ = 0;
  hand_held_ = false;
  for (Queue& queue : queues_) queue.size = 0;  // of ticks that are to come again
}

void SimulatedDrives::advance() noexcept {
  begin_faults();
  const double h_s = static_cast<double>(period_ns_) * 1e-9 / kSubSteps;
  for (unsigned i = 0; i < kSubSteps; ++i) sub_step(h_s * (i + 1));
  ++tick_;
  now_ns_ += period_ns_;
  const AxisVector rate = rates();
  for (unsigned i = 0; i < drives_.size(); ++i) {
    DriveFrame frame;
    while (drives_[i].send_cyclic(shaft_of(i, rate), frame)) post(i, frame);
  }
}

void SimulatedDrives::sub_step(double into_s) noexcept {
  const double h_s = static_cast<double>(period_ns_) * 1e-9 / kSubSteps;
  const AxisVector rate = rates();
  AxisVector effort{};
  for (unsigned i = 0; i < drives_.size(); ++i) {
    const DriveAxis& axis = description_.axes[i];
    effort[i] = axis.sign * axis.ratio * drives_[i].torque_Nm(shaft_of(i, rate).speed_rad_per_s);
    drives_[i].advance(h_s);
  }
  const double time_s = static_cast<double>(tick_) * static_cast<double>(period_ns_) * 1e-9 + into_s;
  plant_.step(h_s, effort, false, hand_.target_at(hand_held_ ? 0.0 : time_s));
}

DriveShaft SimulatedDrives::shaft_of(unsigned axis, const AxisVector& rate) const noexcept {
  const DriveAxis& of = description_.axes[axis];
  return {of.offset_rad + of.sign * of.ratio * plant_.coordinates()[axis], of.sign * of.ratio * rate[axis]};
}

Wrenchd SimulatedDrives::commanded_wrench() const noexcept {
  AxisVector effort{};
  for (unsigned i = 0; i < drives_.size(); ++i)
    effort[i] = description_.axes[i].sign * description_.axes[i].ratio * drives_[i].commanded_Nm();
  return kinematics_.wrench_of(plant_.coordinates(), effort);
}

bool SimulatedDrives::acts(DriveFaultKind kind, unsigned axis) const noexcept {
  for (unsigned i = 0; i < fault_count_; ++i) {
    const DriveFault& fault = faults_[i];
    if (fault.kind == kind && (fault.axis == kAllAxes || fault.axis == axis) && tick_ >= fault.tick &&
        tick_ - fault.tick < fault.ticks)
      return true;
  }
  return false;
}

void SimulatedDrives::inject(const DriveFault& fault) noexcept {
  const auto over = [this](const DriveFault& one) { return tick_ > one.tick && tick_ - one.tick >= one.ticks; };
  const auto end = std::remove_if(faults_.begin(), faults_.begin() + fault_count_, over);
  fault_count_ = static_cast<unsigned>(end - faults_.begin());
  faults_[fault_count_++] = fault;
}

void SimulatedDrives::begin_faults() noexcept {
  for (unsigned axis = 0; axis < drives_.size(); ++axis) {
    const DriveAxis& of = description_.axes[axis];
    drives_[axis].wrap_position(acts(DriveFaultKind::kWrapped, axis) ? 2 * of.position_range_rad : 0.0);
    drives_[axis].saturate_speed(acts(DriveFaultKind::kSpeed, axis));
  }
  for (unsigned i = 0; i < fault_count_; ++i) {
    const DriveFault& fault = faults_[i];
    if (tick_ != fault.tick) continue;
    for (unsigned axis = 0; axis < drives_.size(); ++axis) {
      if (fault.axis != kAllAxes && fault.axis != axis) continue;
      if (fault.kind == DriveFaultKind::kFaultFlag) drives_[axis].report_fault(0xa);
      if (fault.kind == DriveFaultKind::kDisabled) drives_[axis].disable();
      if (fault.kind == DriveFaultKind::kRestarted) drives_[axis].restart();
    }
  }
}

void SimulatedDrives::hear(unsigned bus, const DriveFrame& frame) noexcept {
  const AxisVector rate = rates();
  for (unsigned i = 0; i < drives_.size(); ++i) {
    if (description_.axes[i].bus != bus) continue;
    if (acts(DriveFaultKind::kNoCommand, i) || acts(DriveFaultKind::kRestarted, i)) continue;
    DriveFrame reply;
    if (drives_[i].hear(frame, shaft_of(i, rate), reply)) post(i, reply);
  }
}

void SimulatedDrives::post(unsigned axis, const DriveFrame& frame) noexcept {
  if (acts(DriveFaultKind::kNoAnswer, axis)) return;
  const unsigned bus = description_.axes[axis].bus;
  Mail mail{{frame, now_ns_}, tick_};
  if (acts(DriveFaultKind::kLate, axis)) {
    mail.from_tick = tick_ + 2;
    mail.received.arrival_ns += 2 * period_ns_;
  }
  if (acts(DriveFaultKind::kForeignId, axis)) mail.received.frame.id = frame.id + 1;
  if (acts(DriveFaultKind::kUndefinedId, axis)) mail.received.frame.id = 0x5a5;
  if (acts(DriveFaultKind::kShort, axis)) mail.received.frame.size = static_cast<std::uint8_t>(frame.size - 3);
  put(bus, mail);
  if (acts(DriveFaultKind::kTwice, axis)) put(bus, mail);
}

void SimulatedDrives::put(unsigned bus, const Mail& mail) noexcept {
  Queue& queue = queues_[bus];
  if (queue.size == queue.mails.size()) return;
  queue.mails[(queue.first + queue.size++) % queue.mails.size()] = mail;
}

bool SimulatedDrives::fetch(unsigned bus, ReceivedDriveFrame& received) noexcept {
  Queue& queue = queues_[bus];
  for (unsigned looked = 0; looked < queue.size; ++looked) {
    const Mail mail = queue.mails[queue.first];
    queue.first = static_cast<unsigned>((queue.first + 1) % queue.mails.size());
    --queue.size;
    if (mail.from_tick <= tick_) {
      received = mail.received;
      return true;
    }
    put(bus, mail);  // not there yet: behind the others
  }
  return false;
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
