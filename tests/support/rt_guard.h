// Counts what real-time code must not do: allocations, frees, lock operations and page faults of the calling thread,
// between the guard's construction and the question.
//
// Linking this puts its own malloc, free and pthread lock functions in front of the C library's, for the whole test
// program. Link target: tactus_rt_guard. Thread: [any]; each thread counts for itself. Guards may be nested.
// Bound: under AddressSanitizer and ThreadSanitizer, which need these functions for themselves, nothing is counted:
// available() is false and the counters stay 0. Page faults are counted always, by the kernel.
#pragma once

#include <cstdint>

namespace tactus::test {

struct RtCounters {
  std::uint64_t allocations{0};  // malloc, calloc, realloc, aligned_alloc ..., and so every operator new
  std::uint64_t frees{0};        // of something; free(nullptr) does nothing
  std::uint64_t locks{0};        // mutex and read-write locks taken, tried or not; waits on conditions
  std::uint64_t minor_faults{0}, major_faults{0};
};

class RtGuard {
 public:
  RtGuard() noexcept : before_(now()) {}

  static bool available() noexcept;

  std::uint64_t allocations() const noexcept { return now().allocations - before_.allocations; }
  std::uint64_t frees() const noexcept { return now().frees - before_.frees; }
  std::uint64_t locks() const noexcept { return now().locks - before_.locks; }
  std::uint64_t minor_faults() const noexcept { return now().minor_faults - before_.minor_faults; }
  std::uint64_t major_faults() const noexcept { return now().major_faults - before_.major_faults; }

 private:
  static RtCounters now() noexcept;
  RtCounters before_;
};

}  // namespace tactus::test
