// Seeded random numbers for tests, the same with every standard library, whose distributions differ.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "rt/base/sanitizer.h"
#include "rt/base/spatial.h"

namespace tactus::test {

// How often a property is tried. Under the address sanitizer, where each try takes ten times as long, a tenth: it
// watches what is done, which is the same in each, and the other builds judge what comes out.
constexpr int tries(int count) { return TACTUS_ADDRESS_SANITIZER ? (count + 9) / 10 : count; }

// 64-bit linear congruential generator, constants of Knuth's MMIX.
class Congruential {
 public:
  explicit Congruential(std::uint64_t seed) : state_(seed * 2862933555777941757ull + 3037000493ull) {}
  double unit() {  // [0, 1)
    state_ = state_ * 6364136223846793005ull + 1442695040888963407ull;
    return static_cast<double>(state_ >> 11) * 0x1p-53;
  }

 private:
  std::uint64_t state_;
};

class MersenneTwister {
 public:
  explicit MersenneTwister(std::uint64_t seed) : engine_(static_cast<std::uint32_t>(seed)) {}
  double unit() { return (static_cast<double>(engine_()) + 0.5) * 0x1p-32; }  // (0, 1)

 private:
  std::mt19937 engine_;
};

template <class Generator>
class RandomOf {
 public:
  explicit RandomOf(std::uint64_t seed) : generator_(seed) {}

  double operator()(double low, double high) { return low + (high - low) * generator_.unit(); }  // uniform
  double symmetric(double size = 1) { return (*this)(-size, size); }
  double log_uniform(double low, double high) { return std::exp((*this)(std::log(low), std::log(high))); }
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>((*this)(0.0, n)); }

  Vec3d vector(double size = 1) {  // each component in [-size, size)
    const double x = symmetric(size), y = symmetric(size), z = symmetric(size);
    return {x, y, z};
  }
  Vec3d direction() {  // unit length, uniform on the sphere
    while (true) {
      const Vec3d v = vector();
      const double n = norm(v);
      if (n > 0.1 && n < 1.0) return v * (1.0 / n);
    }
  }
  Quatd rotation() {
    while (true) {
      const Quatd q{symmetric(), symmetric(), symmetric(), symmetric()};
      const double n = norm(q);
      if (n > 0.1 && n < 1.0) return normalized(q);
    }
  }
  Posed pose(double size = 1) {
    const Vec3d at = vector(size);
    return {at, rotation()};
  }

 private:
  Generator generator_;
};

using Random = RandomOf<Congruential>;

}  // namespace tactus::test
