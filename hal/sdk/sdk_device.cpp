#include "hal/sdk/sdk_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "firmware/faults.h"
#include "rt/base/clock.h"

namespace tactus::hal {
namespace {

using haptics::DeviceState;
using haptics::ReadStatus;

constexpr std::uint32_t kStack_KiB = 512;  // of the library, whose depth is not known
constexpr int kPriority = 85;

std::uint32_t number_of(firmware::Fault fault) noexcept { return static_cast<std::uint32_t>(fault); }

}  // namespace

SdkDevice::SdkDevice(std::unique_ptr<SdkPort> port, std::int64_t period_ns)
    : port_(std::move(port)), period_ns_(period_ns), properties_(port_->properties()) {}

Result<std::unique_ptr<SdkDevice>> SdkDevice::start(std::unique_ptr<SdkPort> port, std::int64_t period_ns) {
  std::unique_ptr<SdkDevice> device(new SdkDevice(std::move(port), period_ns));
  if (Status status = device->measure(); !status.ok()) return status;
  device->publish();
  const auto body = [](void* context) noexcept { static_cast<SdkDevice*>(context)->work(); };
  if (Status status = device->thread_.start(kStack_KiB, {.cpu = -1, .priority = kPriority}, body, device.get());
      !status.ok())
    return status;
  return device;
}

SdkDevice::~SdkDevice() {
  stop_.store(true, std::memory_order_relaxed);
  thread_.join();
}

Status SdkDevice::measure() {
  std::vector<std::int64_t> times_ns;
  unsigned good = 0;
  for (unsigned i = 0; i < kTrials; ++i) {
    SdkState state;
    const std::int64_t began_ns = MonotonicClock::now_ns();
    const SdkResult result = port_->exchange({}, state);
    times_ns.push_back(MonotonicClock::now_ns() - began_ns);
    if (result != SdkResult::kError) ++good;
    if (result == SdkResult::kGone) return Status::error("the device does not answer its library");
  }
  if (2 * good < kTrials)
    return Status::error(fmt::format("the library refused {} of {} exchanges", kTrials - good, kTrials));
  std::sort(times_ns.begin(), times_ns.end());
  const std::int64_t median_ns = times_ns[kTrials / 2], late_ns = times_ns[kTrials * 9 / 10];
  if (median_ns > period_ns_ / 2)
    return Status::error(fmt::format("the library takes {} us for an exchange; accepted: at most {} at this rate",
                                     median_ns / 1000, period_ns_ / 2000));
  properties_.delay_s = 1e-9 * static_cast<double>(period_ns_ + late_ns);
  return Status::good();
}

// --- the haptic thread

void SdkDevice::publish() noexcept {
  requests_.writing() = {command_.wrench, state_ == DeviceState::kForce, command_.sequence};
  requests_.publish();
}

void SdkDevice::read(haptics::DeviceInput& input) noexcept {
  ++periods_;
  if (missed_ <= kBrake) ++missed_;  // 1: the command that the last write brought
  if (missed_ > kBrake && state_ == DeviceState::kForce) {
    brake(number_of(firmware::Fault::kCommandsLost));
    publish();
  }
  const Answer* fresh = answers_.take();
  input.status = gone_.load(std::memory_order_relaxed) ? ReadStatus::kDisconnected
                 : fresh != nullptr                    ? ReadStatus::kFresh
                                                       : ReadStatus::kMissing;
  if (fresh != nullptr) {
    sample_.device_from_tool = fresh->state.device_from_tool;
    sample_.buttons = fresh->state.buttons;
    sample_.echoed_sequence = fresh->echoed;
    ++sample_.sequence;
    sample_.device_time_ns = periods_ * static_cast<std::uint64_t>(period_ns_);
    if (!fresh->state.may_push && state_ == DeviceState::kForce) brake(number_of(firmware::Fault::kMotorBus));
  }
  sample_.state = state_;
  sample_.device_fault = fault_;
  sample_.missed_commands = missed_ > 0 ? missed_ - 1 : 0;
  input.sample = sample_;
}

void SdkDevice::write(const haptics::DeviceCommand& command) noexcept {
  const bool rearms = command.rearm != 0 && command_.rearm == 0;  // the edge, so that a stuck flag has no effect
  command_ = command;
  missed_ = 0;
  if (!is_finite(command.wrench)) {
    command_.wrench = {};
    brake(number_of(firmware::Fault::kEffortNotFinite));
  } else if (command.wanted == DeviceState::kBrake) {
    brake(0);
  } else if (state_ != DeviceState::kBrake) {
    state_ = command.wanted == DeviceState::kForce ? DeviceState::kForce : DeviceState::kIdle;
  } else if (rearms) {
    state_ = DeviceState::kIdle;
    fault_ = 0;
  }
  const double force = norm(command_.wrench.force), torque = norm(command_.wrench.torque);
  if (force > properties_.max_force_N) command_.wrench.force *= properties_.max_force_N / force;
  if (torque > properties_.max_torque_Nm) command_.wrench.torque *= properties_.max_torque_Nm / torque;
  publish();
}

void SdkDevice::brake(std::uint32_t fault) noexcept {
  if (state_ != DeviceState::kBrake) fault_ = fault;  // the first cause
  state_ = DeviceState::kBrake;
}

// --- the library's thread

void SdkDevice::work() noexcept {
  Request newest;
  unsigned silent = 0, lost = 0;
  bool forces = false;
  std::int64_t deadline_ns = MonotonicClock::now_ns();
  while (!stop_.load(std::memory_order_relaxed)) {
    if (const Request* request = requests_.take()) {
      newest = *request;
      silent = 0;
    } else if (silent < kBrake) {
      ++silent;
    }
    const bool wants = newest.force && silent < kBrake;
    if (wants != forces && port_->enable_forces(wants)) forces = wants;  // refused: asked for again in the next period
    const double share = silent < kFade ? 1.0 : static_cast<double>(kBrake - silent) / (kBrake - kFade + 1);
    const Wrenchd wrench =
        forces && wants ? Wrenchd{newest.wrench.force * share, newest.wrench.torque * share} : Wrenchd{};
    Answer answer;
    const SdkResult result = port_->exchange(wrench, answer.state);
    // Where forces were not asked for, it says nothing that they are off; where they were and the library refused, all.
    answer.state.may_push = !wants || (forces && answer.state.may_push);
    lost = result == SdkResult::kFresh ? 0 : lost + 1;
    gone_.store(result == SdkResult::kGone || lost >= kGone, std::memory_order_relaxed);
    if (result == SdkResult::kFresh) {
      answer.echoed = newest.sequence;
      answers_.writing() = answer;
      answers_.publish();
    }
    // A call that took longer than a period makes no burst afterwards.
    deadline_ns = std::max(deadline_ns + period_ns_, MonotonicClock::now_ns());
    MonotonicClock::sleep_until_ns(deadline_ns);
  }
  SdkState last;
  (void)port_->exchange({}, last);
  (void)port_->enable_forces(false);
}

}  // namespace tactus::hal
