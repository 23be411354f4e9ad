#include "rt/thread/periodic_thread.h"

#include <sys/resource.h>

namespace tactus::loop::detail {

ThreadUsage thread_usage() noexcept {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  return {static_cast<std::uint64_t>(usage.ru_minflt), static_cast<std::uint64_t>(usage.ru_majflt),
          static_cast<std::uint64_t>(usage.ru_nivcsw)};
}

}  // namespace tactus::loop::detail
