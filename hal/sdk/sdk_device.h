// A device through a maker's library (sdk_port.h): a thread of its own, or the library's, calls the library, and the
// haptic thread exchanges values with it.
//
// That thread makes an exchange per period. If no new request comes for kFadeMissed periods it lowers the force, at
// kBrakeMissed it switches the forces off: a library's own watchdog is fed by this thread, so it would not see a loop
// that stopped. It does so when it ends, too, and at once when the library reports a fault. The age of a sample is the
// time that an exchange takes, measured at the start, and a period: properties().delay_s, for the gain check. A call
// that takes longer: no fresh sample, and the loop fades. No call for kGone periods: disconnected.
// Faults: 1 commands lost, 4 not finite (firmware/faults.h), and those of sdk_faults.h. Thread: start(), destructor
// [setup]; read(), write() [rt]: atomic exchanges of values, no lock, no system call.
#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <utility>

#include "hal/host_states.h"
#include "hal/sdk/sdk_port.h"
#include "rt/base/latest_value.h"
#include "rt/thread/realtime_thread.h"

namespace tactus::hal {

// Owns the port and the thread that calls it.
class SdkWorker {
 public:
  static constexpr unsigned kGone = 50;     // periods in a row
  static constexpr unsigned kTrials = 200;  // exchanges without force, timed at the start

  // Error, one line: the library refuses exchanges, reports a fault, takes more than half of a period in the median, or
  // its scheduler does not call.
  static Result<std::unique_ptr<SdkWorker>> start(std::unique_ptr<SdkPort> port, std::int64_t period_ns);
  ~SdkWorker();
  // Ends the exchanges without force. False: a call has not returned in `longest_ns`, and the worker must not be
  // destroyed, ever.
  bool end(std::int64_t longest_ns) noexcept;
  SdkWorker(const SdkWorker&) = delete;
  SdkWorker& operator=(const SdkWorker&) = delete;

  const haptics::DeviceProperties& properties() const noexcept { return properties_; }
  void read(haptics::DeviceInput& input) noexcept;
  void write(const haptics::DeviceCommand& command) noexcept;
  // [normal] Why no samples come, as a half line; empty: nothing is known.
  std::string trouble() const;
  std::string watchdog() const { return port_->watchdog(); }

 private:
  struct Request {
    Wrenchd wrench;
    bool force{false};
    std::uint64_t sequence{0};
  };
  struct Answer {
    SdkState state;
    bool fresh{false};  // false: only the fault counts
    std::uint64_t echoed{0};
  };

  SdkWorker(std::unique_ptr<SdkPort> port, std::int64_t period_ns);
  Status run_trials();
  Status judge_trials();
  void publish() noexcept;
  // --- used by the library's thread
  void called() noexcept;
  void work() noexcept;
  void try_once() noexcept;
  SdkResult call_port(const Wrenchd& wrench, SdkState& state) noexcept;
  void exchange() noexcept;
  void finish() noexcept;

  std::unique_ptr<SdkPort> port_;
  std::int64_t period_ns_;
  haptics::DeviceProperties properties_;
  // --- used by the haptic thread
  haptics::DeviceSample sample_;
  HostStates states_;
  std::uint64_t periods_{0};
  unsigned silent_{0};  // periods without an answer, in a row
  LatestValue<Request> requests_;
  LatestValue<Answer> answers_;
  // --- used by the library's thread; before its start and after its end by the owner's
  Request newest_;
  unsigned unasked_{0}, lost_{0};  // periods without a request; without a fresh sample
  std::uint32_t reported_{0};      // the fault that the library reported, until force is no longer requested
  bool forces_{false};
  std::array<std::int64_t, kTrials> trial_ns_{};
  unsigned good_trials_{0};
  SdkState trial_state_;
  SdkResult trial_result_{SdkResult::kError};
  std::atomic<unsigned> trials_{0};
  std::atomic<bool> stop_{false}, finished_{false}, gone_{false};
  // Results of the newest exchange, for trouble().
  std::atomic<SdkResult> told_{SdkResult::kFresh};
  std::atomic<std::uint32_t> told_fault_{0};
  std::atomic<std::int64_t> ended_ns_{0}, took_ns_{0};
  loop::RealtimeThread thread_;  // declared last: it uses the other members
};

class SdkDevice {
 public:
  static constexpr unsigned kGone = SdkWorker::kGone, kTrials = SdkWorker::kTrials;
  // A last call of the library that takes longer is not waited for, and its thread is kept: the device's own watchdog
  // ends the force.
  static constexpr std::int64_t kLastCall_ns = 1'000'000'000;

  // As SdkWorker::start.
  static Result<std::unique_ptr<SdkDevice>> start(std::unique_ptr<SdkPort> port, std::int64_t period_ns);
  ~SdkDevice();
  SdkDevice(const SdkDevice&) = delete;
  SdkDevice& operator=(const SdkDevice&) = delete;

  const haptics::DeviceProperties& properties() const noexcept { return worker_->properties(); }
  void read(haptics::DeviceInput& input) noexcept { worker_->read(input); }
  void write(const haptics::DeviceCommand& command) noexcept { worker_->write(command); }
  // [normal] As of SdkWorker.
  std::string trouble() const { return worker_->trouble(); }
  std::string watchdog() const { return worker_->watchdog(); }

 private:
  explicit SdkDevice(std::unique_ptr<SdkWorker> worker) noexcept : worker_(std::move(worker)) {}

  std::unique_ptr<SdkWorker> worker_;
};

static_assert(haptics::HapticDevice<SdkDevice>);

}  // namespace tactus::hal
