// Uniform random numbers that are the same for a seed with every standard library, whose distributions differ.
// SplitMix64 (Steele, Lea and Flood 2014).
// Thread: one owner.
#pragma once

#include <cstdint>

#include "rt/base/spatial.h"

namespace tactus::sim {

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}

  std::uint64_t next() noexcept {
    state_ += 0x9e3779b97f4a7c15ull;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  double uniform() noexcept { return static_cast<double>(next() >> 11) * 0x1p-53; }  // in [0, 1)
  double symmetric() noexcept { return 2 * uniform() - 1; }                          // in [-1, 1)
  Vec3d vector(double most) noexcept {                                               // each component in [-most, most)
    const double x = symmetric(), y = symmetric(), z = symmetric();
    return {most * x, most * y, most * z};
  }

 private:
  std::uint64_t state_;
};

}  // namespace tactus::sim
