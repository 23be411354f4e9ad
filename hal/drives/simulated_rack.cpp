#include "hal/drives/simulated_rack.h"

#include <algorithm>

namespace tactus::hal {

SimulatedRack::SimulatedRack(const DriveDescription& description, std::int64_t period_ns)
    : description_(description), period_ns_(period_ns) {
  for (const DriveAxis& axis : description_.axes) drives_.emplace_back(description_.family, axis);
}

void SimulatedRack::restart_clock() noexcept {
  tick_ = 0;
  for (Queue& queue : queues_) queue.size = 0;  // their ticks will occur again
}

void SimulatedRack::end_period(const DriveShafts& shafts) noexcept {
  ++tick_;
  now_ns_ += period_ns_;
  for (unsigned i = 0; i < drives_.size(); ++i) {
    DriveFrame frame;
    while (drives_[i].send_cyclic(shafts[i], frame)) post(i, frame);
  }
}

bool SimulatedRack::acts(DriveFaultKind kind, unsigned axis) const noexcept {
  for (unsigned i = 0; i < fault_count_; ++i) {
    const DriveFault& fault = faults_[i];
    if (fault.kind == kind && (fault.axis == kAllAxes || fault.axis == axis) && tick_ >= fault.tick &&
        tick_ - fault.tick < fault.ticks)
      return true;
  }
  return false;
}

void SimulatedRack::inject(const DriveFault& fault) noexcept {
  const auto over = [this](const DriveFault& one) { return tick_ > one.tick && tick_ - one.tick >= one.ticks; };
  const auto end = std::remove_if(faults_.begin(), faults_.begin() + fault_count_, over);
  fault_count_ = static_cast<unsigned>(end - faults_.begin());
  faults_[fault_count_++] = fault;
}

void SimulatedRack::begin_period() noexcept {
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

void SimulatedRack::hear(unsigned bus, const DriveFrame& frame, const DriveShafts& shafts) noexcept {
  for (unsigned i = 0; i < drives_.size(); ++i) {
    if (description_.axes[i].bus != bus || !is_here(i)) continue;
    if (acts(DriveFaultKind::kNoCommand, i) || acts(DriveFaultKind::kRestarted, i)) continue;
    DriveFrame reply;
    if (drives_[i].hear(frame, shafts[i], reply)) post(i, reply);
  }
}

void SimulatedRack::post(unsigned axis, const DriveFrame& frame) noexcept {
  if (acts(DriveFaultKind::kNoAnswer, axis) || !is_here(axis)) return;
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

void SimulatedRack::put(unsigned bus, const Mail& mail) noexcept {
  Queue& queue = queues_[bus];
  if (queue.size == queue.mails.size()) return;
  queue.mails[(queue.first + queue.size++) % queue.mails.size()] = mail;
}

bool SimulatedRack::fetch(unsigned bus, ReceivedDriveFrame& received) noexcept {
  Queue& queue = queues_[bus];
  for (unsigned looked = 0; looked < queue.size; ++looked) {
    const Mail mail = queue.mails[queue.first];
    queue.first = static_cast<unsigned>((queue.first + 1) % queue.mails.size());
    --queue.size;
    if (mail.from_tick <= tick_) {
      received = mail.received;
      return true;
    }
    put(bus, mail);  // not due yet: goes to the end of the queue
  }
  return false;
}

}  // namespace tactus::hal
