// A thread of its own with the real-time set-up of realtime_setup.h: what a loop, or a link's far end, runs on.
//
// start() returns when the thread's set-up is done and reported; then body(context) runs there, once. Signals are
// blocked in the thread, so that they go to the main one. Thread: start(), join(), report() [setup] by the owner;
// running() [any]; the body [rt] on the new thread. What ends the body is the owner's affair: join() waits for it.
// Bound: the stack is of the size asked for, whole pages, at least the system's least; SetupRequest::stack_KiB of it
// are touched. Beyond it the program ends with a fault: the page below the stack is nobody's.
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
  // Joins. What the body uses must outlive this: an owner declares its thread last.
  ~RealtimeThread() { join(); }
  RealtimeThread(const RealtimeThread&) = delete;
  RealtimeThread& operator=(const RealtimeThread&) = delete;

  // Fails when one runs that was not joined, or the system gives no thread. Missing privileges are no failure: see
  // report().
  Status start(std::uint32_t stack_KiB, const SetupRequest& setup, Body body, void* context);
  // Waits for the body's end, however long; then start() may be called again. Without a thread: nothing.
  void join() noexcept;

  // From start() to join().
  bool started() const noexcept { return started_; }
  // From start() to the body's end.
  bool running() const noexcept { return running_.load(std::memory_order_acquire); }
  // After start().
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
