// Timing in the experiments: CPU time of threads that stay on their cores. Thread: one, unless a function says
// otherwise.
#pragma once

#include <functional>
#include <semaphore>
#include <thread>

namespace tactus::experiment {

// CPU time of this thread [us]; time taken by other programs is not included.
double thread_time_us() noexcept;

double cpu_time_us(const std::function<void()>& work);  // of running it on this thread [us]

// Monotonic wall time [us], for work shared by several threads.
double wall_time_us() noexcept;

// Pins this thread to its current core and flushes denormals, for all engines equally.
void settle_on_core() noexcept;

// Does work on another core than the caller's while that goes on, as in a real-time run. Where this process has one
// core alone, `begin` does it there and then. Make it before settle_on_core.
class OtherCore {
 public:
  OtherCore();
  ~OtherCore();
  OtherCore(const OtherCore&) = delete;
  OtherCore& operator=(const OtherCore&) = delete;

  bool there() const noexcept { return thread_.joinable(); }
  void begin(std::function<void()> work);  // not before `end` of the work begun last
  double end();                            // waits until the work is done; its CPU time [us]

 private:
  void serve(int core) noexcept;

  std::function<void()> work_;  // none: the thread ends
  double took_us_{};
  std::binary_semaphore begin_{0}, done_{0};
  std::thread thread_;
};

}  // namespace tactus::experiment
