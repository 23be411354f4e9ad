// Random number generator of the random worlds: the same seed gives the same numbers on every machine. Thread: one
// owner.
#pragma once

#include <cmath>
#include <cstdint>

#include "rt/base/math.h"
#include "sim/random.h"

namespace tactus::hard_cases {

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : random_(seed) {}
  double uniform(double low, double high) { return low + (high - low) * random_.uniform(); }
  double logarithmic(double low, double high) { return low * std::exp(std::log(high / low) * uniform(0, 1)); }
  bool chance(double p) { return uniform(0, 1) < p; }
  std::uint32_t below(std::uint32_t n) { return static_cast<std::uint32_t>(random_.next() % n); }
  Vec3d vector(double most) {
    const double x = uniform(-most, most), y = uniform(-most, most), z = uniform(-most, most);
    return {x, y, z};
  }

 private:
  sim::Random random_;
};

}  // namespace tactus::hard_cases
