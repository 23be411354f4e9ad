// A helper thread of a Linux board's link, for system calls that block until the other end of the cable acts.
//
// Its body checks stopping() after every call. stop() interrupts a blocking call by a real-time signal whose handler
// does nothing, repeatedly until the body has returned. The stack is small, so that locking memory stays cheap.
// Thread: [setup], the owner's. Bound: stop() takes as long as the body needs between two of its blocking calls.
#pragma once

#include <pthread.h>

#include <atomic>
#include <string>

namespace tactus::firmware {

class BoardThread {
 public:
  using Body = void (*)(void* context) noexcept;

  BoardThread() = default;
  ~BoardThread() { stop(); }
  BoardThread(const BoardThread&) = delete;
  BoardThread& operator=(const BoardThread&) = delete;

  // priority: SCHED_FIFO 1 to 99; 0: a normal thread. Returns the error in one line, empty: none. A refused priority is
  // no error: the thread runs with normal priority and realtime() is false.
  std::string start(Body body, void* context, int priority);
  void request_stop() noexcept { stopping_.store(true, std::memory_order_release); }
  void stop() noexcept;
  bool stopping() const noexcept { return stopping_.load(std::memory_order_acquire); }
  bool realtime() const noexcept { return realtime_; }

 private:
  static void* run(void* self) noexcept;

  pthread_t thread_{};
  Body body_{nullptr};
  void* context_{nullptr};
  bool started_{false}, realtime_{false};
  std::atomic<bool> stopping_{false}, ended_{false};
};

}  // namespace tactus::firmware
