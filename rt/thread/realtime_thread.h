// A thread with the real-time set-up of realtime_setup.h. The periodic loop uses it, and so do the threads of device
// links (hal/).
//
// start() returns when the thread's set-up is done and reported; then body(context) runs there, once. Signals are
// blocked in the thread, so the main thread receives them. Thread: start(), join(), report() [setup] by the owner;
// running() [any]; the body [rt] on the new thread. The owner makes the body end: join() only waits for it. Bound: the
// stack has the requested size, in whole pages, at least the system's minimum; SetupRequest::stack_KiB of it are
// touched. Beyond the stack the program ends with a fault: the page below it is a guard page.
#pragma once

#include <atomic>
#include <cstdint>

#include "rt/base/result.h"
#include "rt/thread/realtime_setup.h"

namespace tactus::loop {

class RealtimeThread {
 public:
  using Body = void (*)(void* context) noexcept;

  RealtimeThread() = default;
  // Joins. Everything that the body uses must outlive this object: declare the thread last in its owner.
  ~RealtimeThread() { join(); }
  RealtimeThread(const RealtimeThread&) = delete;
  RealtimeThread& operator=(const RealtimeThread&) = delete;

  // Fails if a thread is not joined yet, or the system cannot create one. Missing privileges are not a failure: see
  // report().
  Status start(std::uint32_t stack_KiB, const SetupRequest& setup, Body body, void* context);
  // Waits without a time limit until the body ends; then start() may be called again. No effect without a thread.
  void join() noexcept;

  // True from start() to join().
  bool started() const noexcept { return started_; }
  // True from start() to the end of the body.
  bool running() const noexcept { return running_.load(std::memory_order_acquire); }
  // Valid after start().
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

}  // namespace tactus::loop
