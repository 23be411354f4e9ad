// A thread of its own that calls a tick at an absolute period, with the real-time set-up of realtime_setup.h.
//
// start() returns when the thread's set-up is done and reported; the first tick is at the next full period of the
// monotonic clock. Signals are blocked in the thread, so that they go to the main one. Thread: all calls [setup] by the
// owner; request_stop() and running() [any]; the tick runs on the new thread, [rt].
// Bound: the stack is of the size asked for, touched and locked; the tick must stay on it.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>

#include "rt/base/result.h"
#include "rt/loop/periodic_loop.h"
#include "rt/loop/realtime_setup.h"

namespace tactus::loop {

struct PeriodicSettings {
  std::chrono::nanoseconds period{std::chrono::milliseconds(1)};
  std::chrono::nanoseconds late_wake{std::chrono::microseconds(100)};
  std::uint32_t stack_KiB{512};  // of the thread; SetupRequest::stack_KiB of it are touched
  SetupRequest setup;
};

namespace detail {

// What does not depend on the tick: creating the thread, waiting for its set-up, joining it.
class RealtimeThread {
 public:
  using Body = void (*)(void* context) noexcept;

  RealtimeThread() = default;
  ~RealtimeThread() { join(); }
  RealtimeThread(const RealtimeThread&) = delete;
  RealtimeThread& operator=(const RealtimeThread&) = delete;

  // Runs body(context) on a new thread after its set-up; returns when the set-up is done.
  Status start(std::uint32_t stack_KiB, const SetupRequest& setup, Body body, void* context);
  void join() noexcept;
  bool started() const noexcept { return started_; }
  bool running() const noexcept { return running_.load(std::memory_order_acquire); }
  const SetupReport& report() const noexcept { return report_; }

 private:
  struct Entry;
  static void* enter(void* entry) noexcept;

  unsigned long thread_{0};  // pthread_t
  bool started_{false};
  std::atomic<bool> running_{false};
  SetupRequest setup_;
  SetupReport report_;
  CpuAwake awake_;
  Body body_{nullptr};
  void* context_{nullptr};
};

// Faults and context switches of the calling thread since it began.
struct ThreadUsage {
  std::uint64_t minor_faults{0}, major_faults{0}, involuntary_switches{0};
};
ThreadUsage thread_usage() noexcept;

}  // namespace detail

template <PeriodicTick Tick, Clock C = MonotonicClock>
class PeriodicThread {
 public:
  // The tick lives elsewhere and must outlive the thread.
  explicit PeriodicThread(Tick& tick, C clock = {}) : tick_(tick), clock_(clock) {}
  ~PeriodicThread() { stop(); }

  // Fails when there is no such period, the thread runs already, or the system gives no thread. Missing privileges are
  // no failure: see setup_report().
  Status start(const PeriodicSettings& settings) {
    if (settings.period <= std::chrono::nanoseconds::zero()) return Status::error("the period must be above 0 ns");
    if (thread_.started()) return Status::error("the loop runs already: stop it first");
    loop_ = {settings.period.count(), settings.late_wake.count()};
    health_ = {};
    stop_.store(false, std::memory_order_relaxed);
    return thread_.start(settings.stack_KiB, settings.setup, &run, this);
  }

  void request_stop() noexcept { stop_.store(true, std::memory_order_relaxed); }
  // Also when the tick ended the loop. Returns after the last tick.
  void stop() noexcept { request_stop(), thread_.join(); }
  // False before start() and once the loop has ended, by stop or by the tick.
  bool running() const noexcept { return thread_.running(); }

  // After start().
  const SetupReport& setup_report() const noexcept { return thread_.report(); }
  // After stop(). While the loop runs, only the tick may look (TickTiming::health).
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
  detail::RealtimeThread thread_;  // last: it is joined before anything that it uses goes
};

}  // namespace tactus::loop
