// What the race programs share: seeded delays on both sides, and the verdict.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <thread>

namespace tactus::test {

// Mostly nothing, sometimes a spin, now and then another thread's turn: every interleaving gets its chance, on one core
// too. xorshift64*; the seed must not be 0.
class Delays {
 public:
  explicit Delays(std::uint64_t seed) : state_(seed) {}

  std::uint64_t random() {
    state_ ^= state_ >> 12;
    state_ ^= state_ << 25;
    state_ ^= state_ >> 27;
    return state_ * 0x2545f4914f6cdd1dull >> 16;
  }
  void maybe_wait() {
    const std::uint64_t r = random();
    if (r % 16 == 0) std::this_thread::yield();
    if (r % 4 == 1) {
      for (std::uint64_t spin = r / 4 % 64; spin > 0; --spin) asm volatile("");
    }
  }

 private:
  std::uint64_t state_;
};

inline void require(bool holds, const char* what, std::uint64_t at) {
  if (holds) return;
  std::printf("FAILED: %s, at %llu\n", what, static_cast<unsigned long long>(at));
  std::fflush(stdout);
  std::_Exit(1);
}

}  // namespace tactus::test
