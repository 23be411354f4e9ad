// Makes the calling thread read and write denormal numbers as zero, and restores the mode that it had.
//
// Every thread that computes calls this first, tests included: decaying velocities otherwise become denormal, which
// makes the CPU up to a hundred times slower, and a run with the flags gives other bits than one without. Thread:
// [setup], each.
#pragma once

#if defined(__x86_64__)
#include <xmmintrin.h>
#else
#include <cstdint>
#endif

namespace tactus {

#if defined(__x86_64__)
inline constexpr unsigned kFlushToZero = 1u << 15, kDenormalsAreZero = 1u << 6;  // bits of MXCSR

inline void set_denormals_flush() noexcept { _mm_setcsr(_mm_getcsr() | kFlushToZero | kDenormalsAreZero); }
inline unsigned float_mode() noexcept { return _mm_getcsr(); }
inline void restore_float_mode(unsigned mode) noexcept { _mm_setcsr(mode); }
inline bool denormals_flushed() noexcept {
  return (_mm_getcsr() & (kFlushToZero | kDenormalsAreZero)) == (kFlushToZero | kDenormalsAreZero);
}
#elif defined(__aarch64__)
inline constexpr std::uint64_t kFlushToZero = 1ull << 24;  // FPCR.FZ: inputs and results

inline std::uint64_t float_mode() noexcept {
  std::uint64_t fpcr = 0;
  asm volatile("mrs %0, fpcr" : "=r"(fpcr));
  return fpcr;
}
inline void restore_float_mode(std::uint64_t mode) noexcept { asm volatile("msr fpcr, %0" : : "r"(mode)); }
inline void set_denormals_flush() noexcept { restore_float_mode(float_mode() | kFlushToZero); }
inline bool denormals_flushed() noexcept { return (float_mode() & kFlushToZero) != 0; }
#else
#error "say how this instruction set flushes denormals"
#endif

}  // namespace tactus
