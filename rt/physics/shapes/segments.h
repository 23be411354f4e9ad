// The closest points of two segments. Inside narrow phase. Thread: [any]; pure, closed form.
// A segment is centre + t half, t in [-1, 1], so the order of its ends does not matter.
#pragma once

#include <algorithm>

#include "rt/base/math.h"

namespace tactus::physics {

struct SegmentParameters {
  double s, t;  // on the first, on the second, in [-1, 1]
};

// `offset`: from the first segment's centre to the second's. Handles segments of length 0 and parallel segments; for
// parallel ones returns the pair nearest to the middle of the first.
inline SegmentParameters closest_on_segments(const Vec3d& half_a, const Vec3d& half_b, const Vec3d& offset) noexcept {
  const auto unit_range = [](double value) noexcept { return std::clamp(value, -1.0, 1.0); };
  const double aa = dot(half_a, half_a), bb = dot(half_b, half_b), ab = dot(half_a, half_b);
  const double ad = dot(half_a, offset), bd = dot(half_b, offset);
  constexpr double tiny = 1e-24;  // m^2: a segment shorter than 1e-12 m is a point
  if (aa <= tiny) return {0.0, bb <= tiny ? 0.0 : unit_range(-bd / bb)};
  if (bb <= tiny) return {unit_range(ad / aa), 0.0};
  // Minimise |offset + t half_b - s half_a|^2: free s for the two lines, then clamp one after the other (Ericson 2005,
  // section 5.1.9). Parallel lines: any s will do.
  const double determinant = aa * bb - ab * ab;
  double s = determinant > 1e-12 * aa * bb ? unit_range((ad * bb - ab * bd) / determinant) : unit_range(ad / aa);
  double t = (ab * s - bd) / bb;
  if (t < -1.0 || t > 1.0) {
    t = unit_range(t);
    s = unit_range((ad + ab * t) / aa);
  }
  return {s, t};
}

}  // namespace tactus::physics
