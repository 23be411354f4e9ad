// Rounds a limit down to three digits, so that a person can write it into a scene and it is still within the limit.
// Thread: [any]. Bound: the digits of a double. A value that is not finite or not above 0 returns max(0, value).
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
