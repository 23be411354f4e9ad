#include "tests/support/rt_guard.h"

#include <dlfcn.h>
#include <pthread.h>
#include <sys/resource.h>

#include <cerrno>
#include <cstddef>
#include <cstdlib>

#include "rt/base/sanitizer.h"

#define TACTUS_INTERPOSE (!TACTUS_ADDRESS_SANITIZER && !TACTUS_THREAD_SANITIZER)

namespace {

// Constant-initialised and without destructor, so that counting itself can neither allocate nor lock.
thread_local constinit tactus::test::RtCounters t_counters;

}  // namespace

namespace tactus::test {

bool RtGuard::available() noexcept { return TACTUS_INTERPOSE != 0; }

RtCounters RtGuard::now() noexcept {
  RtCounters counters = t_counters;
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  counters.minor_faults = static_cast<std::uint64_t>(usage.ru_minflt);
  counters.major_faults = static_cast<std::uint64_t>(usage.ru_majflt);
  return counters;
}

}  // namespace tactus::test

#if TACTUS_INTERPOSE

// The C library keeps its allocator under these names too: no look-up, so no recursion when the look-up allocates.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) {
  ++t_counters.allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++t_counters.allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* block, std::size_t size) {
  ++t_counters.allocations;
  if (block != nullptr) ++t_counters.frees;
  return __libc_realloc(block, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  ++t_counters.allocations;
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++t_counters.allocations;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  ++t_counters.allocations;
  void* got = __libc_memalign(alignment, size);
  if (got == nullptr) return ENOMEM;
  *block = got;
  return 0;
}
void free(void* block) {
  if (block != nullptr) ++t_counters.frees;
  __libc_free(block);
}
}

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
    ++t_counters.locks;
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
