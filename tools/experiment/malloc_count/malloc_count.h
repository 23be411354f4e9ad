// Counts the allocations and frees of each thread, by a malloc and a free of its own in place of the C library's, for
// the whole program: part of tests/support/rt_guard.h, and a shared library that tests link and LD_PRELOAD names. The
// program itself does not contain it, so that a heap profiler sees everything.
//
// Thread: [any], each its own counts. Bound: under AddressSanitizer and ThreadSanitizer, which have their own malloc,
// TACTUS_COUNTS_ALLOCATIONS is 0 and nothing here is defined.
#pragma once

#include <cstdint>

#include "rt/base/sanitizer.h"

#define TACTUS_COUNTS_ALLOCATIONS (!TACTUS_ADDRESS_SANITIZER && !TACTUS_THREAD_SANITIZER)

extern "C" {
// Of the calling thread, since it started: malloc, calloc, realloc, aligned_alloc ..., and so every operator new.
// experiment::allocation_count() looks it up by name.
std::uint64_t tactus_thread_allocations() noexcept;
// Of something: free(nullptr) does nothing.
std::uint64_t tactus_thread_frees() noexcept;
}
