// How often this thread allocated, where the library of tools/experiment/malloc_count counts: its malloc stands before
// the C library's, also for the libraries that are linked. Tests link it;
// LD_PRELOAD=BUILD/tools/libtactus_malloc_count.so has the program count. Thread: [any], each its own. Bound: none.
// Without it, and under a sanitizer, nothing is counted: 0.
#pragma once

#include <cstdint>

namespace tactus::experiment {

bool allocations_are_counted() noexcept;
std::uint64_t allocation_count() noexcept;  // of the calling thread, since it began

}  // namespace tactus::experiment
