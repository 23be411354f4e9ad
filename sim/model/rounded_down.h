// Three digits, downwards: a figure that a person can write into a scene, and that is accepted there when the value is.
// Thread: any. Bound: the digits of a double. What is not finite or not above 0 comes back, at least 0.
#pragma once

#include <algorithm>
#include <cmath>

namespace tactus::sim {

inline double rounded_down(double value) {
  if (!(value > 0) || !std::isfinite(value)) return std::max(0.0, value);
  double unit = 1;
  while (value / unit >= 1000) unit *= 10;
  while (value / unit < 100) unit /= 10;
  return std::floor(value / unit) * unit;
}

}  // namespace tactus::sim
