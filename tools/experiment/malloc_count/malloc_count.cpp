#include "tools/experiment/malloc_count/malloc_count.h"

#include <cerrno>
#include <cstddef>

#if TACTUS_COUNTS_ALLOCATIONS

namespace {

// Constant-initialised, without destructor and at a fixed place of each thread, so that counting itself can neither
// allocate nor lock.
[[gnu::tls_model("initial-exec")]] thread_local constinit std::uint64_t t_allocations = 0, t_frees = 0;

}  // namespace

extern "C" {
std::uint64_t tactus_thread_allocations() noexcept { return t_allocations; }
std::uint64_t tactus_thread_frees() noexcept { return t_frees; }

// The C library keeps its allocator under these names too: no look-up, so no recursion when the look-up allocates.
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

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
  if (block != nullptr) ++t_frees;
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
void free(void* block) {
  if (block != nullptr) ++t_frees;
  __libc_free(block);
}
}

#endif
