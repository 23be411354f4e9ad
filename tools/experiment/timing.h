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

// Does work on another core than the caller's while that waits: as in a real-time run, the work does not displace what
// the caller has in its core's caches. Where this process has one core alone, on that. Make it before settle_on_core.
class OtherCore {
 public:
  OtherCore();
  ~OtherCore();
  OtherCore(const OtherCore&) = delete;
  OtherCore& operator=(const OtherCore&) = delete;

  bool there() const noexcept { return thread_.joinable(); }
  double time_us(std::function<void()> work);  // runs it; its CPU time [us]

 private:
  void serve(int core) noexcept;

  std::function<void()> work_;  // none: the thread ends
  double took_us_{};
  std::binary_semaphore begin_{0}, done_{0};
  std::thread thread_;
};

}  // namespace tactus::experiment
