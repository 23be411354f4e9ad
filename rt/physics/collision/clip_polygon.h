// Polygons above the faces of boxes and hulls: clip by one side (hulls; boxes in box_clip.h), merge close points,
// reduce to four points. Inside narrow phase. Thread: [any]; pure. Bound: linear in the points.
//
// Frame: that of the reference face: u, v along it, w outward. Units: m. A Polygon has `count` and an array `points` of
// u, v, w, `id` (the same corner has the same id from step to step), `kept` (was a point of the last step's manifold)
// and, to be clipped, `line` (label of the line from this point to the next). Noise must not change the choice of
// points: a contact whose points alternate from step to step never comes to rest.
//
// Source: clipping by half planes, Sutherland and Hodgman 1974.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace tactus::physics {

// Points beyond a side by at most this are kept unchanged [m]: in a stack of equal boxes every corner lies on a side,
// and must not alternate between corner and crossing. Equals the solver's slop.
inline constexpr double kSideTolerance = 1e-5;

template <class Polygon>
using PointOf = typename decltype(Polygon::points)::value_type;
template <class Polygon>
void push(Polygon& polygon, const PointOf<Polygon>& point) noexcept {
  // Never full in exact arithmetic. Rounding may fold a thin face once more; that corner may be dropped.
  if (polygon.count < polygon.points.size()) polygon.points[polygon.count++] = point;
}

// Removes what is beyond a side by more than the tolerance. `beyond_of(point)` [m]: distance beyond the side;
// `crossing_id(point)`: id of the crossing of the side with the line that starts at the point; `side`: label of the
// side.
template <class Polygon, class BeyondOf, class CrossingId>
void cut(Polygon& polygon, BeyondOf beyond_of, CrossingId crossing_id, decltype(PointOf<Polygon>::line) side) noexcept {
  constexpr double tolerance = kSideTolerance;
  decltype(Polygon::points) before;
  std::array<double, std::tuple_size_v<decltype(Polygon::points)>> beyond;
  const std::uint32_t count = polygon.count;
  bool all_inside = true;
  for (std::uint32_t k = 0; k < count; ++k) {
    beyond[k] = beyond_of(polygon.points[k]);
    all_inside = all_inside && beyond[k] <= tolerance;
  }
  if (all_inside) return;
  std::copy_n(polygon.points.begin(), count, before.begin());
  polygon.count = 0;
  for (std::uint32_t k = 0; k < count; ++k) {
    const std::uint32_t next = k + 1 == count ? 0 : k + 1;
    const auto &from = before[k], &to = before[next];
    const bool inside = beyond[k] <= tolerance, next_inside = beyond[next] <= tolerance;
    if (inside) push(polygon, from);
    if (inside == next_inside) continue;
    // If the inner point is itself beyond the side, within the tolerance, the crossing is at the end of the tolerance.
    const double shift = beyond[k] <= 0.0 || beyond[next] <= 0.0 ? 0.0 : tolerance;
    const double ratio = (beyond[k] - shift) / (beyond[k] - beyond[next]);
    PointOf<Polygon> point = from;
    point.u += ratio * (to.u - from.u);
    point.v += ratio * (to.v - from.v);
    point.w += ratio * (to.w - from.w);
    point.id = crossing_id(from);
    if (inside) point.line = side;  // from here on the polygon follows the side
    push(polygon, point);
  }
}

// A thin polygon, as where two cards meet at their upper edges, is reduced to a line: of neighbours within 20 um of
// each other the one with the lower id is kept, with the greater depth of both.
template <class Polygon>
void merge_neighbours(Polygon& polygon) noexcept {
  const auto merge = [](PointOf<Polygon>& into, const PointOf<Polygon>& point) noexcept {
    constexpr double near = 2.0 * kSideTolerance;
    if (!(std::abs(into.u - point.u) <= near && std::abs(into.v - point.v) <= near)) return false;
    const double w = std::min(into.w, point.w);
    if (point.id < into.id) into = point;
    into.w = w;
    return true;
  };
  std::uint32_t kept = 0;
  for (std::uint32_t k = 0; k < polygon.count; ++k) {
    if (kept > 0 && merge(polygon.points[kept - 1], polygon.points[k])) continue;
    if (kept != k) polygon.points[kept] = polygon.points[k];
    ++kept;
  }
  if (kept > 1 && merge(polygon.points[0], polygon.points[kept - 1])) --kept;
  polygon.count = kept;
}

// Keeps the points whose separation is at most the margin [m].
template <class Polygon>
void keep_within(double margin, Polygon& polygon) noexcept {
  std::uint32_t within = 0;
  for (std::uint32_t k = 0; k < polygon.count; ++k)
    if (polygon.points[k].w <= margin) polygon.points[within++] = polygon.points[k];
  polygon.count = within;
}

// A point whose separation is at most this may carry load [m].
inline constexpr double kClose = 1e-4;
inline constexpr double kCloseFactor = 2.0;  // on the size that such a point adds

// Keeps the candidate with the best score. The score of a point that may carry load is multiplied by `close_factor`; a
// point of the last step gets `bonus` on its score; of two scores within the tolerance the lower id wins.
template <class Polygon>
struct PointChoice {
  static constexpr std::uint32_t kNone = 0xffffffffu;

  const Polygon& polygon;
  double tolerance, bonus, close_factor;
  double score{};
  std::uint32_t index{kNone};

  void offer(std::uint32_t i, double candidate) noexcept {
    const auto& point = polygon.points[i];
    if (point.w <= (point.kept ? 2.0 * kClose : kClose)) candidate *= close_factor;
    if (point.kept) candidate += bonus;
    if (index != kNone) {
      const bool better = candidate > score + tolerance;
      const bool equal = candidate >= score - tolerance && polygon.points[i].id < polygon.points[index].id;
      if (!better && !equal) return;
    }
    score = candidate;
    index = i;
  }
};

// Chooses at most four points: the deepest, the farthest from it, the one with the largest triangle, the one with the
// largest quadrilateral. A point of the last step stays until another is clearly better: in depth by max(20 um, 0.3 of
// the depth), in size by a tenth of the points' squared span. (With 0.1 in place of 0.3 a heap of 1,000 cubes, stepped
// by 10 ms, never came to rest. 2026-11-22.) A point that may carry load counts double in size. A preference that does
// not depend on the size would choose two points beside each other and leave a corner free: the corner of a card that
// turns by 10 rad/s moves by 0.6 mm in a millisecond, and no point stops it.
template <class Polygon>
void reduce_to_four(Polygon& polygon) noexcept {
  if (polygon.count <= 4) return;
  using Choice = PointChoice<Polygon>;
  const auto& p = polygon.points;
  const std::uint32_t count = polygon.count;
  const auto squared = [&](std::uint32_t i, std::uint32_t j) noexcept {
    return (p[j].u - p[i].u) * (p[j].u - p[i].u) + (p[j].v - p[i].v) * (p[j].v - p[i].v);
  };
  // Twice the signed area of the triangle.
  const auto area = [&](std::uint32_t i, std::uint32_t j, std::uint32_t k) noexcept {
    return (p[j].u - p[i].u) * (p[k].v - p[i].v) - (p[j].v - p[i].v) * (p[k].u - p[i].u);
  };

  double lowest = p[0].w;
  for (std::uint32_t i = 1; i < count; ++i) lowest = std::min(lowest, p[i].w);
  // m: the tolerance is above the noise of a resting contact, the bonus twice the solver's slop.
  Choice deepest{polygon, 1e-6, std::max(2e-5, -0.3 * lowest), 1.0};
  for (std::uint32_t i = 0; i < count; ++i) deepest.offer(i, -p[i].w);
  const std::uint32_t a = deepest.index;

  double span = 0.0;
  for (std::uint32_t i = 0; i < count; ++i) span = std::max(span, squared(a, i));
  const double tolerance = 1e-3 * span, bonus = 0.1 * span;
  Choice farthest{polygon, tolerance, bonus, kCloseFactor};
  for (std::uint32_t i = 0; i < count; ++i)
    if (i != a) farthest.offer(i, squared(a, i));
  const std::uint32_t b = farthest.index;

  Choice third{polygon, tolerance, bonus, kCloseFactor};
  for (std::uint32_t i = 0; i < count; ++i)
    if (i != a && i != b) third.offer(i, std::abs(area(a, b, i)));
  const std::uint32_t c = third.index;

  // The point that adds the largest area outside the triangle, across any of its sides.
  const double turn = area(a, b, c) < 0.0 ? -1.0 : 1.0;
  Choice fourth{polygon, tolerance, bonus, kCloseFactor};
  for (std::uint32_t i = 0; i < count; ++i)
    if (i != a && i != b && i != c)
      fourth.offer(i, std::max({0.0, -turn * area(a, b, i), -turn * area(b, c, i), -turn * area(c, a, i)}));

  // In polygon order, so that the order does not depend on which of them was the deepest.
  std::uint32_t chosen[4] = {a, b, c, fourth.index};
  std::sort(chosen, chosen + 4);
  for (std::uint32_t i = 0; i < 4; ++i) polygon.points[i] = p[chosen[i]];
  polygon.count = 4;
}

}  // namespace tactus::physics
