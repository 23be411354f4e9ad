#include "hal/sdk/sdk_device.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <thread>
#include <vector>

#include "hal/device_words.h"
#include "hal/sdk/sdk_faults.h"
#include "rt/base/clock.h"

namespace tactus::hal {
namespace {

using haptics::DeviceState;
using haptics::ReadStatus;

constexpr std::uint32_t kStack_KiB = 512;  // of the library, whose depth is not known
constexpr int kPriority = 85;
// kPatience_ns: for the trials of a scheduler, in addition to their periods. kLastCall_ns: for its last call.
constexpr std::int64_t kPatience_ns = 1'000'000'000, kLastCall_ns = 100'000'000, kLook_ns = 1'000'000;

// False: `done` did not become true in time.
template <class Done>
bool wait_for(std::int64_t longest_ns, Done&& done) {
  for (const std::int64_t end_ns = MonotonicClock::now_ns() + longest_ns; !done();) {
    if (MonotonicClock::now_ns() > end_ns) return false;
    MonotonicClock::sleep_until_ns(MonotonicClock::now_ns() + kLook_ns);
  }
  return true;
}

}  // namespace

SdkWorker::SdkWorker(std::unique_ptr<SdkPort> port, std::int64_t period_ns)
    : port_(std::move(port)), period_ns_(period_ns), properties_(port_->properties()) {}

Result<std::unique_ptr<SdkWorker>> SdkWorker::start(std::unique_ptr<SdkPort> port, std::int64_t period_ns) {
  std::unique_ptr<SdkWorker> device(new SdkWorker(std::move(port), period_ns));
  device->publish();
  if (device->port_->has_scheduler()) {
    const auto call = [](void* context) noexcept { static_cast<SdkWorker*>(context)->called(); };
    if (Status status = device->port_->start_calls({call, device.get()}, period_ns); !status.ok()) return status;
  }
  if (Status status = device->run_trials(); !status.ok()) return status;
  if (Status status = device->judge_trials(); !status.ok()) return status;
  if (device->port_->has_scheduler()) return device;
  const auto body = [](void* context) noexcept { static_cast<SdkWorker*>(context)->work(); };
  if (Status status = device->thread_.start(kStack_KiB, {.cpu = -1, .priority = kPriority}, body, device.get());
      !status.ok())
    return status;
  return device;
}

bool SdkWorker::end(std::int64_t longest_ns) noexcept {
  stop_.store(true, std::memory_order_relaxed);
  const auto finished = [this] { return finished_.load(std::memory_order_acquire); };
  if (port_->has_scheduler()) {
    if (!wait_for(kLastCall_ns, finished)) {
      // The scheduler has stopped, or a call does not return; then stop_calls() may not return either.
      std::thread([this] {
        port_->stop_calls();
        finish();
      }).detach();
      return wait_for(longest_ns, finished);
    }
    port_->stop_calls();
  } else if (thread_.started() && !wait_for(longest_ns, finished)) {
    return false;
  }
  thread_.join();
  if (!finished()) finish();
  return true;
}

SdkWorker::~SdkWorker() {
  if (!finished_.load(std::memory_order_acquire)) (void)end(std::numeric_limits<std::int64_t>::max() / 2);
}

Result<std::unique_ptr<SdkDevice>> SdkDevice::start(std::unique_ptr<SdkPort> port, std::int64_t period_ns) {
  auto worker = SdkWorker::start(std::move(port), period_ns);
  if (!worker.ok()) return worker.status();
  return std::unique_ptr<SdkDevice>(new SdkDevice(std::move(worker).value()));
}

SdkDevice::~SdkDevice() {
  // A worker whose thread is in a call that does not return is kept until the process ends.
  static auto* const abandoned = new std::vector<std::unique_ptr<SdkWorker>>;
  if (!worker_->end(kLastCall_ns)) abandoned->push_back(std::move(worker_));
}

Status SdkWorker::run_trials() {
  if (port_->has_scheduler()) {
    const auto done = [this] { return trials_.load(std::memory_order_acquire) == kTrials; };
    if (wait_for(kTrials * period_ns_ + kPatience_ns, done)) return Status::good();
    return Status::error(
        fmt::format("the library's scheduler made {} of {} calls; restart the maker's driver, or unplug the device and "
                    "plug it in again",
                    trials_.load(std::memory_order_acquire), kTrials));
  }
  while (trials_.load(std::memory_order_relaxed) < kTrials) {
    try_once();
    if (trial_result_ == SdkResult::kGone) break;
  }
  return Status::good();
}

Status SdkWorker::judge_trials() {
  if (trial_state_.fault != 0) return Status::error(describe_device_fault(trial_state_.fault));
  if (trial_result_ == SdkResult::kGone) return Status::error("the device does not answer its library");
  if (2 * good_trials_ < kTrials)
    return Status::error(fmt::format("the library refused {} of {} exchanges", kTrials - good_trials_, kTrials));
  std::sort(trial_ns_.begin(), trial_ns_.end());
  const std::int64_t median_ns = trial_ns_[kTrials / 2], late_ns = trial_ns_[kTrials * 9 / 10];
  if (median_ns > period_ns_ / 2)
    return Status::error(fmt::format("the library takes {} us for an exchange; accepted: at most {} at this rate",
                                     median_ns / 1000, period_ns_ / 2000));
  properties_.delay_s = 1e-9 * static_cast<double>(period_ns_ + late_ns);
  ended_ns_.store(MonotonicClock::now_ns(), std::memory_order_relaxed);
  return Status::good();
}

std::string SdkWorker::trouble() const {
  constexpr auto relaxed = std::memory_order_relaxed;
  if (const std::uint32_t fault = told_fault_.load(relaxed); fault != 0) return describe_device_fault(fault);
  const std::int64_t silent_ns = MonotonicClock::now_ns() - ended_ns_.load(relaxed), took_ns = took_ns_.load(relaxed);
  if (silent_ns > kGone * period_ns_)
    return fmt::format("its library makes no exchange since {} ms: it does not return, or calls no more",
                       silent_ns / 1'000'000);
  if (took_ns > period_ns_)
    return fmt::format("its library took {:.1f} ms for an exchange", 1e-6 * static_cast<double>(took_ns));
  switch (told_.load(relaxed)) {
    case SdkResult::kOld:
      return "its library gives the old sample again";
    case SdkResult::kError:
      return "its library refuses exchanges, or gives poses that are none";
    case SdkResult::kGone:
      return "its library says that the device is not there";
    default:
      return {};
  }
}

// --- the haptic thread

void SdkWorker::publish() noexcept {
  const haptics::DeviceCommand& command = states_.command();
  requests_.writing() = {command.wrench, states_.state() == DeviceState::kForce, command.sequence};
  const double force = norm(command.wrench.force), torque = norm(command.wrench.torque);
  Wrenchd& wrench = requests_.writing().wrench;
  if (force > properties_.max_force_N) wrench.force *= properties_.max_force_N / force;
  if (torque > properties_.max_torque_Nm) wrench.torque *= properties_.max_torque_Nm / torque;
  requests_.publish();
}

void SdkWorker::read(haptics::DeviceInput& input) noexcept {
  ++periods_;
  states_.begin_period();
  if (states_.commands_lost() && states_.state() == DeviceState::kForce) {
    states_.brake(number_of(firmware::Fault::kCommandsLost));
    publish();
  }
  const Answer* answer = answers_.take();
  silent_ = answer != nullptr ? 0 : std::min(silent_ + 1, kGone);
  const bool fresh = answer != nullptr && answer->fresh;
  const bool gone = silent_ == kGone || gone_.load(std::memory_order_relaxed);
  input.status = gone ? ReadStatus::kDisconnected : fresh ? ReadStatus::kFresh : ReadStatus::kMissing;
  if (fresh) {
    sample_.device_from_tool = answer->state.device_from_tool;
    sample_.buttons = answer->state.buttons;
    sample_.echoed_sequence = answer->echoed;
    ++sample_.sequence;
    sample_.device_time_ns = periods_ * static_cast<std::uint64_t>(period_ns_);
  }
  if (answer != nullptr && answer->state.fault != 0 && states_.state() == DeviceState::kForce)
    states_.brake(answer->state.fault);
  sample_.state = states_.state();
  sample_.device_fault = states_.fault();
  sample_.missed_commands = states_.missed();
  input.sample = sample_;
}

void SdkWorker::write(const haptics::DeviceCommand& command) noexcept {
  if (states_.accept(command) == HostStates::Next::kFollow)
    states_.enter(command.wanted == DeviceState::kForce ? DeviceState::kForce : DeviceState::kIdle);
  publish();
}

// --- the library's thread

void SdkWorker::try_once() noexcept {
  const unsigned trial = trials_.load(std::memory_order_relaxed);
  const std::int64_t began_ns = MonotonicClock::now_ns();
  trial_state_ = {};
  trial_result_ = port_->exchange({}, trial_state_);
  trial_ns_[trial] = MonotonicClock::now_ns() - began_ns;
  good_trials_ += trial_result_ != SdkResult::kError;
  trials_.store(trial + 1, std::memory_order_release);
}

SdkResult SdkWorker::call_port(const Wrenchd& wrench, SdkState& state) noexcept {
  constexpr auto relaxed = std::memory_order_relaxed;
  const std::int64_t began_ns = MonotonicClock::now_ns();
  const SdkResult result = port_->exchange(wrench, state);
  const std::int64_t ended_ns = MonotonicClock::now_ns();
  told_.store(result, relaxed);
  told_fault_.store(state.fault, relaxed);
  took_ns_.store(ended_ns - began_ns, relaxed);
  ended_ns_.store(ended_ns, relaxed);
  return result;
}

void SdkWorker::exchange() noexcept {
  if (const Request* request = requests_.take()) {
    newest_ = *request;
    unasked_ = 0;
  } else if (unasked_ < kBrakeMissed) {
    ++unasked_;
  }
  if (!newest_.force) reported_ = 0;  // the haptic thread has the fault, or requests no force for another reason
  const bool wants = newest_.force && unasked_ < kBrakeMissed && reported_ == 0;
  if (wants != forces_ && port_->enable_forces(wants)) forces_ = wants;
  const double share = share_after(unasked_);
  const Wrenchd wrench =
      forces_ && wants ? Wrenchd{newest_.wrench.force * share, newest_.wrench.torque * share} : Wrenchd{};
  Answer answer;
  const SdkResult result = call_port(wrench, answer.state);
  answer.fresh = result == SdkResult::kFresh;
  // A fault counts only while forces are requested: the library's own, or kSdkForcesOff if the library refused to
  // switch them on.
  if (wants && reported_ == 0) reported_ = answer.state.fault != 0 ? answer.state.fault : forces_ ? 0 : kSdkForcesOff;
  answer.state.fault = reported_;
  lost_ = answer.fresh ? 0 : std::min(lost_ + 1, kGone);
  gone_.store(result == SdkResult::kGone || lost_ >= kGone, std::memory_order_relaxed);
  if (!answer.fresh && reported_ == 0) return;
  answer.echoed = newest_.sequence;
  answers_.writing() = answer;
  answers_.publish();
}

void SdkWorker::finish() noexcept {
  SdkState last;
  (void)port_->exchange({}, last);
  (void)port_->enable_forces(false);
  finished_.store(true, std::memory_order_release);
}

// Called by the library's scheduler.
void SdkWorker::called() noexcept {
  if (finished_.load(std::memory_order_relaxed)) return;
  if (stop_.load(std::memory_order_relaxed)) return finish();
  if (trials_.load(std::memory_order_relaxed) < kTrials) return try_once();
  exchange();
}

// Runs on the device's own thread.
void SdkWorker::work() noexcept {
  std::int64_t deadline_ns = MonotonicClock::now_ns();
  while (!stop_.load(std::memory_order_relaxed)) {
    exchange();
    // After a call of more than a period the missed calls are not made up for.
    deadline_ns = std::max(deadline_ns + period_ns_, MonotonicClock::now_ns());
    MonotonicClock::sleep_until_ns(deadline_ns);
  }
  finish();
}

}  // namespace tactus::hal
