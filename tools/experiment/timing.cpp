#include "tools/experiment/timing.h"

#include <sched.h>
#include <time.h>

#include <utility>

#include "rt/base/clock.h"
#include "rt/base/denormals.h"
#include "rt/thread/realtime_setup.h"

namespace tactus::experiment {
namespace {

void stay_on(int core) noexcept {
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(static_cast<unsigned>(core), &one);
  static_cast<void>(sched_setaffinity(0, sizeof one, &one));  // if not permitted, the scheduler chooses
}

// Without rest: who wakes a thread enters the kernel in the middle of a tick, and a core that halted is cold.
void wait_for(std::binary_semaphore& semaphore) noexcept {
  while (!semaphore.try_acquire()) {}
}

}  // namespace

double thread_time_us() noexcept {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

double cpu_time_us(const std::function<void()>& work) {
  const double begin_us = thread_time_us();
  work();
  return thread_time_us() - begin_us;
}

double wall_time_us() noexcept { return 1e-3 * static_cast<double>(MonotonicClock::now_ns()); }

void settle_on_core() noexcept {
  set_denormals_flush();
  if (const int core = sched_getcpu(); core >= 0) stay_on(core);
}

OtherCore::OtherCore() {
  const int here = sched_getcpu();
  for (const int core : loop::allowed_cpus())
    if (core != here) {
      stay_on(here);  // until settle_on_core
      thread_ = std::thread([this, core] { serve(core); });
      return;
    }
}

OtherCore::~OtherCore() {
  if (!there()) return;
  work_ = nullptr;
  begin_.release();
  thread_.join();
}

void OtherCore::serve(int core) noexcept {
  stay_on(core);
  set_denormals_flush();
  for (wait_for(begin_); work_; wait_for(begin_)) {
    took_us_ = cpu_time_us(work_);
    done_.release();
  }
}

void OtherCore::begin(std::function<void()> work) {
  work_ = std::move(work);
  if (there())
    begin_.release();
  else
    took_us_ = cpu_time_us(work_);
}

double OtherCore::end() {
  if (there()) wait_for(done_);
  return took_us_;
}

}  // namespace tactus::experiment
