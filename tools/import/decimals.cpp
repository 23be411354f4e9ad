#include "tools/import/decimals.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

namespace tactus::scene_import {

std::string decimal(double number, double rounding) {
  constexpr int kMostDigits = 12;
  if (std::abs(number) <= rounding) return "0";
  for (int digits = 1; digits <= kMostDigits; ++digits) {
    const double shorter = std::strtod(fmt::format("{:.{}g}", number, digits).c_str(), nullptr);
    if (std::abs(shorter - number) <= rounding) return fmt::format("{}", shorter);
  }
  return fmt::format("{}", number);
}

std::string decimal(double number) { return decimal(number, kRounding * std::abs(number)); }

}  // namespace tactus::scene_import
