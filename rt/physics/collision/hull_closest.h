// Closest-point queries on a hull: the point nearest to a given one, and the part of a line above a face. Inside narrow
// phase. Thread: [any]; pure. Frame: the hull's. Units: m. Bound: every face and every edge at most once.
#pragma once

#include "rt/physics/shapes/hull_view.h"

namespace tactus::physics {

// Range of t on a line centre + t half; empty if low > high.
struct LineRange {
  double low{-1.0}, high{1.0};
  bool empty() const noexcept { return !(low <= high); }
};

// Clips the range to value + t slope <= 0.
inline void cut_range(LineRange& range, double value, double slope) noexcept {
  if (slope > 0.0)
    range.high = smaller(range.high, -value / slope);
  else if (slope < 0.0)
    range.low = larger(range.low, -value / slope);
  else if (value > 0.0)
    range = {1.0, -1.0};
}

// The part of the line centre + t half, t in [-1, 1], inside the prism over the face.
LineRange range_above_face(const HullView& hull, std::uint32_t face, const Vec3d& centre, const Vec3d& half) noexcept;

bool is_above_face(const HullView& hull, std::uint32_t face, const Vec3d& point) noexcept;

struct HighestFace {
  std::uint32_t face{0};
  double height{};  // m: of the point above the face's plane; negative: the point is inside
};
// The face whose plane the point is highest above (the lower index on a tie).
HighestFace highest_face(const HullView& hull, const Vec3d& point) noexcept;

// Returns the point itself if it is inside.
Vec3d closest_on_hull(const HullView& hull, const Vec3d& point) noexcept;

}  // namespace tactus::physics
