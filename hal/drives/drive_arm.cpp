#include "hal/drives/drive_arm.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "hal/drives/drive_faults.h"

namespace tactus::hal {
namespace {

using haptics::DeviceState;
using haptics::ReadStatus;

constexpr unsigned kSilentPeriods = 10, kEnablingPeriods = 20;
constexpr double kLongestStart_s = 0.05;  // of a drive that reports kStarting; a moteus takes 10 to 15 ms
// An answer belongs to this period if it is younger than this many periods.
constexpr double kFreshPeriods = 1.5;

bool is_enabled(const DriveAnswer& answer) noexcept { return !answer.has_mode || answer.mode == DriveMode::kEnabled; }

bool is_on(DriveMode mode) noexcept {
  return mode == DriveMode::kEnabled || mode == DriveMode::kStarting || mode == DriveMode::kOther;
}

}  // namespace

DriveArm::DriveArm(const DeviceProfile& profile, std::int64_t period_ns, DriveBuses buses)
    : drives_(profile.description.drives),
      codec_(&codec_of(drives_.family)),
      kinematics_(profile.kinematics),
      properties_(profile.properties),
      max_effort_(profile.plant.max_effort),
      period_ns_(period_ns),
      buses_(std::move(buses)),
      count_(static_cast<unsigned>(drives_.axes.size())),
      longest_start_(static_cast<unsigned>(std::lround(kLongestStart_s * 1e9 / static_cast<double>(period_ns)))) {
  properties_.delay_s = static_cast<double>(profile.transport_delay_ticks) * static_cast<double>(period_ns) * 1e-9;
  const double share = std::min(1.0, static_cast<double>(period_ns) * 1e-9 / drives_.full_effort_s);
  for (unsigned i = 0; i < count_; ++i) {
    max_effort_[i] = std::min(max_effort_[i], drives_.axes[i].torque_range_Nm * drives_.axes[i].ratio);
    max_slope_[i] = share * max_effort_[i];
  }
}

DriveArm::~DriveArm() {
  send_all(DriveAction::kBrake, {});  // no torque: a drive keeps its last command
  send_all(DriveAction::kDisable, {});
}

Status DriveArm::start() {
  ReceivedDriveFrame dropped;
  for (const auto& bus : buses_)
    while (bus->receive(dropped)) {}
  counters_ = {};
  send_all(DriveAction::kPoll, {});
  return Status::good();
}

// --- reading

void DriveArm::read(haptics::DeviceInput& input) noexcept {
  ++periods_;
  states_.begin_period();
  malformed_ = false;
  for (unsigned i = 0; i < count_; ++i) axes_[i].answered = false;
  for (unsigned bus = 0; bus < buses_.size(); ++bus) drain(bus);
  input.status = status_of_period();
  if (input.status == ReadStatus::kFresh) {
    q_ = coordinates();
    sample_.device_from_tool = kinematics_.pose_of(q_);
    sample_.echoed_sequence = states_.command().sequence;
    ++sample_.sequence;
    sample_.device_time_ns = periods_ * static_cast<std::uint64_t>(period_ns_);
    if (states_.state() == DeviceState::kReset) states_.enter(DeviceState::kIdle);
  }
  watch_drives();
  watch_commands();
  sample_.state = states_.state();
  sample_.device_fault = states_.fault();
  sample_.missed_commands = states_.missed();
  input.sample = sample_;
}

void DriveArm::drain(unsigned bus) noexcept {
  ReceivedDriveFrame received;
  for (unsigned i = 0; i < kMaxFrames && buses_[bus]->receive(received); ++i) take(bus, received);
}

void DriveArm::take(unsigned bus, const ReceivedDriveFrame& received) noexcept {
  const auto age = static_cast<double>(buses_[bus]->now_ns() - received.arrival_ns);
  for (unsigned i = 0; i < count_; ++i) {
    if (drives_.axes[i].bus != bus) continue;
    DriveAnswer answer = axes_[i].answer;
    answer.has_position = false;
    const DriveDecode decoded = codec_->decode(drives_.axes[i], received.frame, answer);
    if (decoded == DriveDecode::kForeign) continue;
    if (decoded == DriveDecode::kMalformed) {
      ++counters_.malformed;
      malformed_ = true;
      return;
    }
    if (answer.has_position && age < kFreshPeriods * static_cast<double>(period_ns_)) {
      if (axes_[i].answered) ++counters_.repeated;
      axes_[i].answered = true;
    }
    axes_[i].answer = answer;
    return;
  }
  ++counters_.foreign;
}

ReadStatus DriveArm::status_of_period() noexcept {
  for (const auto& bus : buses_) {
    if (bus->connected()) continue;
    ++counters_.disconnected;
    return ReadStatus::kDisconnected;
  }
  bool complete = true;
  for (unsigned i = 0; i < count_; ++i) {
    axes_[i].silent_periods = axes_[i].answered ? 0 : axes_[i].silent_periods + 1;
    complete = complete && axes_[i].answered;
  }
  if (complete) {
    ++counters_.fresh;
    return ReadStatus::kFresh;
  }
  ++(malformed_ ? counters_.corrupt : counters_.missing);
  return malformed_ ? ReadStatus::kCorrupt : ReadStatus::kMissing;
}

AxisVector DriveArm::coordinates() const noexcept {
  AxisVector q{};
  for (unsigned i = 0; i < count_; ++i) {
    const DriveAxis& axis = drives_.axes[i];
    q[i] = axis.sign * (axes_[i].answer.position_rad - axis.offset_rad) / axis.ratio;
  }
  return q;
}

void DriveArm::watch_drives() noexcept {
  if (step_ == Step::kIdle)  // the command that disabled it was lost
    for (const Axis& axis : axes_)
      to_disable_ = to_disable_ || (axis.answered && axis.answer.has_mode && is_on(axis.answer.mode));
  if (step_ != Step::kForce && step_ != Step::kEnabling) return;
  for (unsigned i = 0; i < count_; ++i) {
    const Axis& axis = axes_[i];
    if (axis.answer.has_mode && axis.answer.fault != 0)
      return brake(drive_fault_of(i, drives_.family, axis.answer.fault));
    if (axis.silent_periods >= kSilentPeriods) return brake(kDriveSilent + i);
    if (step_ == Step::kForce && !is_enabled(axis.answer) && axis.answered)
      return brake(drive_left_force(i, drives_.family, axis.answer.mode));
    if (step_ == Step::kForce && lacks_torque(i)) return brake(kDriveLacksTorque + i);
  }
  if (step_ == Step::kEnabling) watch_enabling();
}

// Reports FORCE once each drive is starting or enabled; torque is sent once all drives are enabled.
void DriveArm::watch_enabling() noexcept {
  bool all_enabled = true, all_taken = true;
  for (unsigned i = 0; i < count_; ++i) {
    const bool enabled = is_enabled(axes_[i].answer);
    all_enabled = all_enabled && enabled;
    all_taken = all_taken && (enabled || axes_[i].answer.mode == DriveMode::kStarting);
  }
  if (all_taken) states_.enter(DeviceState::kForce);
  if (all_enabled) {
    step_ = Step::kForce;
  } else if (++enabling_periods_ > (all_taken ? longest_start_ : kEnablingPeriods)) {
    for (unsigned i = 0; i < count_; ++i)
      if (!is_enabled(axes_[i].answer)) return brake(drive_never_enabled(i, drives_.family));
  }
}

bool DriveArm::lacks_torque(unsigned i) noexcept {
  Axis& axis = axes_[i];
  if (!codec_->tells_torque || !axis.answered) return false;
  const DriveAxis& of = drives_.axes[i];
  const double damping_Nm = -of.damping_Nms_per_rad * axis.answer.speed_rad_per_s;
  return axis.torque.lacks(axis.answer.torque_Nm, damping_Nm, of.torque_range_Nm);
}

// Host-side watchdog for missing write() calls. If this process stops, the drives' own watchdogs act.
void DriveArm::watch_commands() noexcept {
  if (states_.missed() == 0) return;
  if (states_.commands_lost() && (step_ == Step::kForce || step_ == Step::kEnabling))
    brake(number_of(firmware::Fault::kCommandsLost));
  send_step(share_after(states_.missed()));
}

void DriveArm::brake(std::uint32_t fault) noexcept {
  states_.brake(fault);
  brake_drives();
}

void DriveArm::brake_drives() noexcept {
  step_ = Step::kBraking;
  for (Axis& axis : axes_) axis.effort = 0;
}

// --- writing

void DriveArm::write(const haptics::DeviceCommand& command) noexcept {
  switch (states_.accept(command)) {
    case HostStates::Next::kStay:
      brake_drives();
      break;
    case HostStates::Next::kRearmed:
      step_ = Step::kClearing;
      break;
    case HostStates::Next::kFollow:
      choose_step();
      break;
  }
  send_step(1.0);
}

// Selects the next step from the drives' present state towards the wanted state.
void DriveArm::choose_step() noexcept {
  if (states_.state() == DeviceState::kReset) return;
  if (states_.command().wanted == DeviceState::kForce) {
    if (step_ == Step::kForce || step_ == Step::kEnabling) return;
    step_ = Step::kEnabling;
    enabling_periods_ = 0;
    for (unsigned i = 0; i < count_; ++i) {  // answers from before the enabling do not count
      axes_[i].effort = 0;
      axes_[i].torque.reset();
      axes_[i].answer.fault = 0;
      axes_[i].answer.has_mode = codec_->tells_enabled;
      axes_[i].answer.mode = DriveMode::kDisabled;
    }
  } else {
    if (step_ == Step::kForce || step_ == Step::kEnabling)
      step_ = Step::kLeaving;  // one command without torque, which the drives keep, before they are disabled
    else
      step_ = Step::kIdle;
    states_.enter(DeviceState::kIdle);
  }
}

void DriveArm::send_step(double share) noexcept {
  AxisVector effort{};
  if (step_ == Step::kIdle) {
    if (!std::exchange(to_disable_, false)) return send_all(DriveAction::kPoll, effort);
    return send_all(DriveAction::kDisable, effort);
  }
  to_disable_ = true;
  if (step_ == Step::kEnabling) return send_all(DriveAction::kEnable, effort);
  if (step_ == Step::kBraking) return send_all(DriveAction::kBrake, effort);
  if (step_ == Step::kClearing) return send_all(DriveAction::kClear, effort);
  if (step_ == Step::kLeaving) return send_all(DriveAction::kTorque, effort);
  Wrenchd wrench = states_.command().wrench;
  const double force = norm(wrench.force), torque = norm(wrench.torque);
  if (force > properties_.max_force_N) wrench.force = wrench.force * (properties_.max_force_N / force);
  if (torque > properties_.max_torque_Nm) wrench.torque = wrench.torque * (properties_.max_torque_Nm / torque);
  const AxisVector wanted = kinematics_.efforts_of(q_, wrench);
  for (unsigned i = 0; i < count_; ++i) {
    const double asked = std::clamp(share * wanted[i], -max_effort_[i], max_effort_[i]);
    // An effort may drop to zero at once, which is safe; only its growth away from zero is limited in slope.
    const double low = std::min(0.0, axes_[i].effort) - max_slope_[i];
    const double high = std::max(0.0, axes_[i].effort) + max_slope_[i];
    effort[i] = std::clamp(asked, low, high);
    axes_[i].effort = effort[i];
  }
  send_all(DriveAction::kTorque, effort);
}

void DriveArm::send_all(DriveAction action, const AxisVector& effort) noexcept {
  for (unsigned i = 0; i < count_; ++i) {
    const DriveAxis& axis = drives_.axes[i];
    const double torque_Nm = axis.sign * effort[i] / axis.ratio;
    axes_[i].torque.sent(torque_Nm);
    const DriveFrame frame = codec_->encode(axis, {.action = action,
                                                   .torque_Nm = torque_Nm,
                                                   .damping_Nms_per_rad = axis.damping_Nms_per_rad,
                                                   .round_up = (periods_ & 1) != 0});
    if (frame.size > 0 && !buses_[axis.bus]->send(frame)) ++counters_.not_sent;
  }
}

}  // namespace tactus::hal
