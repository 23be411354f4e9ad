// What the clipped faces of boxes and of hulls have in common: cutting by one side, leaving out what coincides, and the
// four points that stand for the rest. Inside narrow phase. Thread: [any]; pure. Bound: linear in the points.
//
// Frame: the reference face's own: u, v along it, w outward from it. Units: m. A Polygon has `count` and an array
// `points` of u, v, w, `id` (the same corner has the same id from step to step), `line` (label of the line from this
// point to the next) and `kept` (it was among the points of the last step). Noise must not change the points from step
// to step: a contact whose points take turns never comes to rest.
// Source: clipping by half planes, Sutherland and Hodgman 1974.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace tactus::physics {

// What is beyond a side by no more than this stays as it is [m]: in a stack of equal boxes every corner lies on a
// side, and must not take turns between being a corner and a crossing. The solver's slop.
inline constexpr double kSideTolerance = 1e-5;

template <class Polygon>
using PointOf = typename decltype(Polygon::points)::value_type;
template <class Polygon>
void push(Polygon& polygon, const PointOf<Polygon>& point) noexcept {
  // Never full in exact arithmetic; rounding may fold a sliver of a face once more, and that corner is no loss.
  if (polygon.count < polygon.points.size()) polygon.points[polygon.count++] = point;
}

// Cuts away what is beyond a side by more than the tolerance. `beyond_of(point)` [m]: how far it is beyond;
// `crossing_id(point)`: of the line that begins there and the side; `side`: the label of the side.
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
    // Where the inner one is itself beyond the side, within the tolerance, the crossing is at the tolerance's end.
    const double shift = beyond[k] <= 0.0 || beyond[next] <= 0.0 ? 0.0 : tolerance;
    const double ratio = (beyond[k] - shift) / (beyond[k] - beyond[next]);
    PointOf<Polygon> point = from;
    point.u += ratio * (to.u - from.u), point.v += ratio * (to.v - from.v), point.w += ratio * (to.w - from.w);
    point.id = crossing_id(from);
    if (inside) point.line = side;  // from here the polygon follows the side
    push(polygon, point);
  }
}

// A sliver of contact, as where two cards meet at their upper edges, is a line: of neighbours within 20 um of each
// other the lower id stays, with the depth of the deeper.
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
  for (std::uint32_t k = 0; k < polygon.count; ++k)
    if (kept == 0 || !merge(polygon.points[kept - 1], polygon.points[k])) polygon.points[kept++] = polygon.points[k];
  if (kept > 1 && merge(polygon.points[0], polygon.points[kept - 1])) --kept;
  polygon.count = kept;
}

// A point within this of the other surface may carry load, and goes before one that can not [m].
inline constexpr double kClose = 1e-4;

// Keeps the best score seen. A point of the last step has `bonus` on its score; what beats another by less than the
// tolerance does so only if its id is lower.
template <class Polygon>
struct PointChoice {
  static constexpr std::uint32_t kNone = 0xffffffffu;

  const Polygon& polygon;
  double tolerance, bonus, close_bonus;
  double score{};
  std::uint32_t index{kNone};

  void offer(std::uint32_t i, double candidate) noexcept {
    const auto& point = polygon.points[i];
    if (point.kept) candidate += bonus;
    if (point.w <= (point.kept ? 2.0 * kClose : kClose)) candidate += close_bonus;
    if (index != kNone) {
      const bool better = candidate > score + tolerance;
      const bool equal = candidate >= score - tolerance && polygon.points[i].id < polygon.points[index].id;
      if (!better && !equal) return;
    }
    score = candidate, index = i;
  }
};

// Chooses at most four: the deepest, the farthest from it, the largest triangle, the largest quadrilateral; first of
// those that may carry load. The points of the last step stay until another beats them clearly: in depth by 20 um and
// three tenths, in size by half of what the points span. (With a tenth and 20 um a heap of 1,000 cubes, stepped by
// 10 ms, never came to rest: 5e-4 m/s; with these, below 1e-8. 2026-11-22.)
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
  Choice deepest{polygon, 1e-6, std::max(2e-5, -0.3 * lowest), 0.0};
  for (std::uint32_t i = 0; i < count; ++i) deepest.offer(i, -p[i].w);
  const std::uint32_t a = deepest.index;

  double span = 0.0;
  for (std::uint32_t i = 0; i < count; ++i) span = std::max(span, squared(a, i));
  const double tolerance = 1e-3 * span, bonus = 0.5 * span, close_bonus = 4.0 * span;
  Choice farthest{polygon, tolerance, bonus, close_bonus};
  for (std::uint32_t i = 0; i < count; ++i)
    if (i != a) farthest.offer(i, squared(a, i));
  const std::uint32_t b = farthest.index;

  Choice third{polygon, tolerance, bonus, close_bonus};
  for (std::uint32_t i = 0; i < count; ++i)
    if (i != a && i != b) third.offer(i, std::abs(area(a, b, i)));
  const std::uint32_t c = third.index;

  // What adds most outside the triangle, across any of its sides.
  const double turn = area(a, b, c) < 0.0 ? -1.0 : 1.0;
  Choice fourth{polygon, tolerance, bonus, close_bonus};
  for (std::uint32_t i = 0; i < count; ++i)
    if (i != a && i != b && i != c)
      fourth.offer(i, std::max({-turn * area(a, b, i), -turn * area(b, c, i), -turn * area(c, a, i)}));

  // In their own order, so that it does not matter which of them was the deepest.
  std::uint32_t chosen[4] = {a, b, c, fourth.index};
  std::sort(chosen, chosen + 4);
  for (std::uint32_t i = 0; i < 4; ++i) polygon.points[i] = p[chosen[i]];
  polygon.count = 4;
}

}  // namespace tactus::physics
