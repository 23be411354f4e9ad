// Number of allocations of a thread, counted by the library of tools/experiment/malloc_count. Its malloc replaces that
// of the C library, also in linked libraries. Tests link it; for the program use
// LD_PRELOAD=BUILD/tools/libtactus_malloc_count.so. Thread: [any], each its own. Bound: none.
// Returns 0 without the library and under a sanitizer.
#pragma once

#include <cstdint>

namespace tactus::experiment {

bool allocations_are_counted() noexcept;
std::uint64_t allocation_count() noexcept;  // of the calling thread, since it started

}  // namespace tactus::experiment
