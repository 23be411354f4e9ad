// How often this thread allocated: the program's own malloc counts, also for the libraries that it links.
//
// Only programs that link this library count; the counter is a thread-local increment. Thread: [any], each its own.
// Bound: none. Under a sanitizer, which has a malloc of its own, nothing is counted.
#pragma once

#include <cstdint>

namespace tactus::experiment {

bool allocations_are_counted() noexcept;
std::uint64_t allocation_count() noexcept;  // of the calling thread, since it began

}  // namespace tactus::experiment
