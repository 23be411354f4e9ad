#include "tools/experiment/timing.h"

#include <sched.h>
#include <time.h>

#include "rt/base/clock.h"
#include "rt/base/denormals.h"

namespace tactus::experiment {

double thread_time_us() noexcept {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return 1e6 * static_cast<double>(now.tv_sec) + 1e-3 * static_cast<double>(now.tv_nsec);
}

double wall_time_us() noexcept { return 1e-3 * static_cast<double>(MonotonicClock::now_ns()); }

void settle_on_core() noexcept {
  set_denormals_flush();
  const int core = sched_getcpu();
  if (core < 0) return;
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(static_cast<unsigned>(core), &one);
  static_cast<void>(sched_setaffinity(0, sizeof one, &one));  // if not permitted, the scheduler chooses
}

}  // namespace tactus::experiment
