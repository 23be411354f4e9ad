// The closest points of two segments. Inside narrow phase. Thread: [any]; pure, closed form.
// A segment is centre + t half, t in [-1, 1]: it never needs to know which end is which.
#pragma once

#include <algorithm>

#include "rt/base/math.h"

namespace tactus::physics {

template <class T>
struct SegmentParameters {
  T s, t;  // on the first, on the second, in [-1, 1]
};

// `offset`: from the first segment's centre to the second's. Degenerate (length 0) and parallel segments included;
// parallel ones give the pair nearest to the first one's middle.
template <class T>
SegmentParameters<T> closest_on_segments(const Vec3<T>& half_a, const Vec3<T>& half_b, const Vec3<T>& offset) noexcept {
  const auto unit_range = [](T value) noexcept { return std::clamp(value, T(-1), T(1)); };
  const T aa = dot(half_a, half_a), bb = dot(half_b, half_b), ab = dot(half_a, half_b);
  const T ad = dot(half_a, offset), bd = dot(half_b, offset);
  constexpr T tiny = T(1e-24);  // m^2: a segment shorter than 1e-12 m is a point
  if (aa <= tiny) return {T(0), bb <= tiny ? T(0) : unit_range(-bd / bb)};
  if (bb <= tiny) return {unit_range(ad / aa), T(0)};
  // Minimise |offset + t half_b - s half_a|^2: free s for the two lines, then clamp one after the other (Ericson 2005,
  // section 5.1.9). Parallel lines: any s will do.
  const T determinant = aa * bb - ab * ab;
  T s = determinant > T(1e-12) * aa * bb ? unit_range((ad * bb - ab * bd) / determinant) : unit_range(ad / aa);
  T t = (ab * s - bd) / bb;
  if (t < T(-1) || t > T(1)) {
    t = unit_range(t);
    s = unit_range((ad + ab * t) / aa);
  }
  return {s, t};
}

}  // namespace tactus::physics
