#include "tests/support/rt_guard.h"

#include <dlfcn.h>
#include <pthread.h>
#include <sys/resource.h>

#include <cstdlib>

#include "tools/experiment/malloc_count/malloc_count.h"

namespace {

// Constant-initialised and without destructor, so that counting itself can neither allocate nor lock.
thread_local constinit std::uint64_t t_locks = 0;

}  // namespace

namespace tactus::test {

bool RtGuard::available() noexcept { return TACTUS_COUNTS_ALLOCATIONS != 0; }

RtCounters RtGuard::now() noexcept {
  RtCounters counters{.locks = t_locks};
#if TACTUS_COUNTS_ALLOCATIONS
  counters.allocations = tactus_thread_allocations();
  counters.frees = tactus_thread_frees();
#endif
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  counters.minor_faults = static_cast<std::uint64_t>(usage.ru_minflt);
  counters.major_faults = static_cast<std::uint64_t>(usage.ru_majflt);
  return counters;
}

}  // namespace tactus::test

#if TACTUS_COUNTS_ALLOCATIONS

namespace {

// The library's own function behind the one defined here, looked up at its first use. A version is named where an old
// one of another layout exists under the same name. Constant-initialised: a static with a guard would itself lock.
struct Next {
  const char* name;
  const char* version{nullptr};
  void* found{nullptr};

  template <class Function>
  Function* as() noexcept {
    void* function = __atomic_load_n(&found, __ATOMIC_RELAXED);
    if (function == nullptr) {
      if (version != nullptr) function = dlvsym(RTLD_NEXT, name, version);
      if (function == nullptr) function = dlsym(RTLD_NEXT, name);
      if (function == nullptr) std::abort();
      __atomic_store_n(&found, function, __ATOMIC_RELAXED);
    }
    ++t_locks;
    return reinterpret_cast<Function*>(function);
  }
};

}  // namespace

extern "C" {

int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  static constinit Next next{"pthread_mutex_lock"};
  return next.as<int(pthread_mutex_t*)>()(mutex);
}
int pthread_mutex_trylock(pthread_mutex_t* mutex) noexcept {
  static constinit Next next{"pthread_mutex_trylock"};
  return next.as<int(pthread_mutex_t*)>()(mutex);
}
int pthread_mutex_timedlock(pthread_mutex_t* mutex, const timespec* until) noexcept {
  static constinit Next next{"pthread_mutex_timedlock"};
  return next.as<int(pthread_mutex_t*, const timespec*)>()(mutex, until);
}
int pthread_rwlock_rdlock(pthread_rwlock_t* lock) noexcept {
  static constinit Next next{"pthread_rwlock_rdlock"};
  return next.as<int(pthread_rwlock_t*)>()(lock);
}
int pthread_rwlock_wrlock(pthread_rwlock_t* lock) noexcept {
  static constinit Next next{"pthread_rwlock_wrlock"};
  return next.as<int(pthread_rwlock_t*)>()(lock);
}
int pthread_cond_wait(pthread_cond_t* condition, pthread_mutex_t* mutex) {
  static constinit Next next{"pthread_cond_wait", "GLIBC_2.3.2"};
  return next.as<int(pthread_cond_t*, pthread_mutex_t*)>()(condition, mutex);
}
int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex, const timespec* until) {
  static constinit Next next{"pthread_cond_timedwait", "GLIBC_2.3.2"};
  return next.as<int(pthread_cond_t*, pthread_mutex_t*, const timespec*)>()(condition, mutex, until);
}
int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock, const timespec* until) {
  static constinit Next next{"pthread_cond_clockwait"};
  return next.as<int(pthread_cond_t*, pthread_mutex_t*, clockid_t, const timespec*)>()(condition, mutex, clock, until);
}
}

#endif
