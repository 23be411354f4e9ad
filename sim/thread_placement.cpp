#include "sim/thread_placement.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sched.h>

#include <cstring>

namespace tactus::sim {

Status make_normal(std::thread& thread) {
  const sched_param priority{};
  const int error = pthread_setschedparam(thread.native_handle(), SCHED_OTHER, &priority);
  if (error == 0) return Status::good();
  return Status::error(fmt::format("cannot give the global world's thread normal priority: {}", std::strerror(error)));
}

Status pin(std::thread& thread, int cpu) {
  if (cpu < 0) return Status::good();
  cpu_set_t cpus;
  CPU_ZERO(&cpus);
  if (cpu < CPU_SETSIZE) CPU_SET(static_cast<std::size_t>(cpu), &cpus);
  const int error = pthread_setaffinity_np(thread.native_handle(), sizeof cpus, &cpus);
  if (error == 0) return Status::good();
  return Status::error(fmt::format("cannot run the global world on CPU {}: {}", cpu, std::strerror(error)));
}

}  // namespace tactus::sim
