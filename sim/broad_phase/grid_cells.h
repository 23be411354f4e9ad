// How boxes lie in the cells of PairGrid and BoxGrid.
// Thread: [any]. Frame: any. Units: m, or cells where the name says so. Bound: constant time.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "rt/physics/shapes/shape.h"

namespace tactus::sim {

// A box is smaller than its cell by this factor, so that rounding in x * cells_per_m cannot place its upper corner two
// cells further: below kFarthestCell the product is off by less than 2^40 * 2^-52 = 2.4e-4 of a cell.
inline constexpr double kCellFill = 0.999;
// Cells beyond are folded into the last: still correct, since folding never moves two cells further apart.
inline constexpr double kFarthestCell = 1099511627776.0;  // 2^40

inline std::int64_t cell_at(double x_cells) noexcept {
  const double cell = std::floor(x_cells);
  if (!(cell > -kFarthestCell)) return static_cast<std::int64_t>(-kFarthestCell);  // NaN too
  return static_cast<std::int64_t>(std::min(cell, kFarthestCell));
}

inline double largest_extent(const physics::Aabb& box) noexcept {
  const Vec3d e = box.upper - box.lower;
  return std::max(e.x, std::max(e.y, e.z));
}

}  // namespace tactus::sim
