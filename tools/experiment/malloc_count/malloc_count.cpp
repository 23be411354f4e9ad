// Counts the allocations of each thread: a shared library that replaces malloc, linked by tests and loaded into the
// program with LD_PRELOAD. The program itself does not contain it, so that a heap profiler sees everything. Empty under
// a sanitizer, which replaces malloc itself.
#include <cerrno>
#include <cstddef>
#include <cstdint>

#include "rt/base/sanitizer.h"

#define TACTUS_COUNTS (!TACTUS_ADDRESS_SANITIZER && !TACTUS_THREAD_SANITIZER)

#if TACTUS_COUNTS

namespace {

// Constant-initialised, without destructor and at a fixed place of each thread, so that counting itself can neither
// allocate nor lock.
[[gnu::tls_model("initial-exec")]] thread_local constinit std::uint64_t t_allocations = 0;

}  // namespace

// The C library keeps its allocator under these names too; operator new calls malloc.
extern "C" {
// Allocations of the calling thread since it started; experiment::allocation_count() looks it up by name.
std::uint64_t tactus_thread_allocations() { return t_allocations; }

void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);

void* malloc(std::size_t size) {
  ++t_allocations;
  return __libc_malloc(size);
}
void* calloc(std::size_t count, std::size_t size) {
  ++t_allocations;
  return __libc_calloc(count, size);
}
void* realloc(void* block, std::size_t size) {
  ++t_allocations;
  return __libc_realloc(block, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  ++t_allocations;
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  ++t_allocations;
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** block, std::size_t alignment, std::size_t size) {
  ++t_allocations;
  void* got = __libc_memalign(alignment, size);
  if (got == nullptr) return ENOMEM;
  *block = got;
  return 0;
}
}

#endif
