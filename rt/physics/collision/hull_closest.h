// Inside narrow phase: the point of a hull that is nearest to a given one, and what of a line lies above a face.
// Thread: [any]; pure. Frame: the hull's. Units: m. Bound: every face and every edge at most once.
#pragma once

#include "rt/physics/shapes/hull_view.h"

namespace tactus::physics {

// Of a line centre + t half: t from low to high; empty where low > high.
struct LineRange {
  double low{-1.0}, high{1.0};
  bool empty() const noexcept { return !(low <= high); }
};

// Cuts the range to where value + t slope <= 0.
inline void cut_range(LineRange& range, double value, double slope) noexcept {
  if (slope > 0.0)
    range.high = smaller(range.high, -value / slope);
  else if (slope < 0.0)
    range.low = larger(range.low, -value / slope);
  else if (value > 0.0)
    range = {1.0, -1.0};
}

// The part of the line centre + t half, t in [-1, 1], between the sides of the face: the prism that stands on it.
LineRange range_above_face(const HullView& hull, std::uint32_t face, const Vec3d& centre, const Vec3d& half) noexcept;

bool is_above_face(const HullView& hull, std::uint32_t face, const Vec3d& point) noexcept;

struct HighestFace {
  std::uint32_t face{0};
  double height{};  // m: of the point above the face's plane; negative: it is inside
};
// The face that the point is highest above (the lower one on a tie).
HighestFace highest_face(const HullView& hull, const Vec3d& point) noexcept;

// The point itself where it is inside.
Vec3d closest_on_hull(const HullView& hull, const Vec3d& point) noexcept;

}  // namespace tactus::physics
