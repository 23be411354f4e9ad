// A real-time thread (realtime_thread.h) that calls a tick at an absolute period.
//
// start() returns when the thread's set-up is done and reported; the first tick is at the next full period of the
// monotonic clock. Thread: all calls [setup] by the owner; request_stop() and running() [any]; the tick runs on the new
// thread, [rt]. Bound: the tick must fit the requested stack.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include "rt/thread/periodic_loop.h"
#include "rt/thread/realtime_thread.h"

namespace tactus::loop {

struct PeriodicSettings {
  std::chrono::nanoseconds period{std::chrono::milliseconds(1)};
  std::chrono::nanoseconds late_wake{std::chrono::microseconds(100)};
  std::uint32_t stack_KiB{512};  // of the thread; SetupRequest::stack_KiB of it are touched
  SetupRequest setup;
};

namespace detail {

// Faults and context switches of the calling thread since it began.
struct ThreadUsage {
  std::uint64_t minor_faults{0}, major_faults{0}, involuntary_switches{0};
};
ThreadUsage thread_usage() noexcept;

}  // namespace detail

template <PeriodicTick Tick, Clock C = MonotonicClock>
class PeriodicThread {
 public:
  // `tick` must outlive the thread.
  explicit PeriodicThread(Tick& tick, C clock = {}) : tick_(tick), clock_(clock) {}
  ~PeriodicThread() { stop(); }

  // Fails if the period is not positive, the thread already runs, or the system cannot create a thread. Missing
  // privileges are not a failure: see setup_report().
  Status start(const PeriodicSettings& settings) {
    if (settings.period <= std::chrono::nanoseconds::zero()) return Status::error("the period must be above 0 ns");
    if (thread_.started()) return Status::error("the loop runs already: stop it first");
    loop_ = {settings.period.count(), settings.late_wake.count()};
    health_ = {};
    stop_.store(false, std::memory_order_relaxed);
    return thread_.start(settings.stack_KiB, settings.setup, &run, this);
  }

  void request_stop() noexcept { stop_.store(true, std::memory_order_relaxed); }
  // Returns after the last tick; also valid after the tick has ended the loop.
  void stop() noexcept {
    request_stop();
    thread_.join();
  }
  // False before start() and once the loop has ended, by stop or by the tick.
  bool running() const noexcept { return thread_.running(); }

  // Valid after start().
  const SetupReport& setup_report() const noexcept { return thread_.report(); }
  // Valid after stop(). While the loop runs, only the tick may read it (TickTiming::health).
  const TimingHealth& health() const noexcept { return health_; }

 private:
  static void run(void* self) noexcept { static_cast<PeriodicThread*>(self)->run(); }
  void run() noexcept {
    const detail::ThreadUsage before = detail::thread_usage();
    run_periodic(clock_, loop_, next_full_period_ns(clock_.now_ns(), loop_.period_ns), tick_, stop_, health_);
    const detail::ThreadUsage after = detail::thread_usage();
    health_.minor_faults = after.minor_faults - before.minor_faults;
    health_.major_faults = after.major_faults - before.major_faults;
    health_.involuntary_switches = after.involuntary_switches - before.involuntary_switches;
  }

  Tick& tick_;
  C clock_;
  LoopSettings loop_;
  TimingHealth health_;
  std::atomic<bool> stop_{false};
  RealtimeThread thread_;  // last member: joined before the members that it uses are destroyed
};

}  // namespace tactus::loop
