// Inside narrow phase: the point of a hull that is nearest to a given one, and what of a line lies above a face.
// Thread: [any]; pure. Frame: the hull's. Units: m. Bound: every face and every edge at most once.
#pragma once

#include "rt/physics/shapes/hull_view.h"

namespace tactus::physics {

// Of a line centre + t half: t from low to high; empty where low > high.
template <class T>
struct LineRange {
  T low{T(-1)}, high{T(1)};
  bool empty() const noexcept { return !(low <= high); }
};

// Cuts the range to where value + t slope <= 0.
template <class T>
void cut_range(LineRange<T>& range, T value, T slope) noexcept {
  if (slope > T(0))
    range.high = smaller(range.high, -value / slope);
  else if (slope < T(0))
    range.low = larger(range.low, -value / slope);
  else if (value > T(0))
    range = {T(1), T(-1)};
}

// The part of the line centre + t half, t in [-1, 1], between the sides of the face: the prism that stands on it.
template <class T>
LineRange<T> range_above_face(const HullView<T>& hull, std::uint32_t face, const Vec3<T>& centre,
                              const Vec3<T>& half) noexcept {
  LineRange<T> range;
  const auto loop = hull.topology->loop(face);
  Vec3<T> from = hull.vertex(loop[loop.size() - 1]);
  for (const std::uint8_t i : loop) {
    const Vec3<T> to = hull.vertex(i), outward = cross(to - from, hull.normals[face]);
    cut_range(range, dot(outward, centre - from), dot(outward, half));
    from = to;
  }
  return range;
}

template <class T>
bool is_above_face(const HullView<T>& hull, std::uint32_t face, const Vec3<T>& point) noexcept {
  const auto loop = hull.topology->loop(face);
  Vec3<T> from = hull.vertex(loop[loop.size() - 1]);
  for (const std::uint8_t i : loop) {
    const Vec3<T> to = hull.vertex(i);
    if (dot(cross(to - from, hull.normals[face]), point - from) > T(0)) return false;
    from = to;
  }
  return true;
}

template <class T>
struct HighestFace {
  std::uint32_t face{0};
  T height{};  // m: of the point above the face's plane; negative: it is inside
};
// The face that the point is highest above (the lower one on a tie).
template <class T>
HighestFace<T> highest_face(const HullView<T>& hull, const Vec3<T>& point) noexcept {
  HighestFace<T> best{0, dot(hull.normals[0], point) - hull.offsets[0]};
  for (std::uint32_t f = 1; f < hull.topology->faces; ++f) {
    const T height = dot(hull.normals[f], point) - hull.offsets[f];
    if (height > best.height) best = {f, height};
  }
  return best;
}

// The point itself where it is inside.
template <class T>
Vec3<T> closest_on_hull(const HullView<T>& hull, const Vec3<T>& point) noexcept {
  std::array<T, kMaxHullFaces> height;
  bool outside = false;
  for (std::uint32_t f = 0; f < hull.topology->faces; ++f) {
    height[f] = dot(hull.normals[f], point) - hull.offsets[f];
    if (!(height[f] > T(0))) continue;
    outside = true;
    if (is_above_face(hull, f, point)) return point - hull.normals[f] * height[f];
  }
  if (!outside) return point;
  Vec3<T> best = point;
  T least = T(-1);
  for (std::uint32_t e = 0; e < hull.topology->edges; ++e) {
    const HullEdge& edge = hull.topology->edge[e];
    if (!(height[edge.left] > T(0)) && !(height[edge.right] > T(0))) continue;
    const Vec3<T> from = hull.vertex(edge.from), along = hull.vertex(edge.to) - from;
    const T t = smaller(T(1), larger(T(0), dot(point - from, along) / norm_squared(along)));
    const Vec3<T> on_edge = from + along * t;
    const T distance = norm_squared(point - on_edge);
    if (least >= T(0) && !(distance < least)) continue;
    least = distance, best = on_edge;
  }
  return best;
}

}  // namespace tactus::physics
