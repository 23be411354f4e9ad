#include "rt/physics/hull_clip.h"

#include <algorithm>

namespace tactus::physics {
namespace {

// What is beyond a side by no more than this stays as it is [m]: the solver's slop.
template <class T>
inline constexpr T kSideTolerance = T(1e-5);

template <class T>
void push(HullPolygon<T>& polygon, const HullClipPoint<T>& point) noexcept {
  // Never full in exact arithmetic; rounding may fold a sliver of a face once more, and that corner is no loss.
  if (polygon.count < kMaxHullClipPoints) polygon.points[polygon.count++] = point;
}

// Where the line from `from` to `to` meets the side.
template <class T>
HullClipPoint<T> crossing(const HullClipPoint<T>& from, const HullClipPoint<T>& to, T beyond_from, T beyond_to,
                          std::uint32_t side) noexcept {
  // Where the inner one is itself beyond the side, within the tolerance, the crossing is at the tolerance's end.
  const T shift = beyond_from <= T(0) || beyond_to <= T(0) ? T(0) : kSideTolerance<T>;
  const T ratio = (beyond_from - shift) / (beyond_from - beyond_to);
  return {from.u + ratio * (to.u - from.u), from.v + ratio * (to.v - from.v), from.w + ratio * (to.w - from.w),
          kFirstHullCrossing + from.line * 256u + side, from.line};
}

template <class T>
bool merge(HullClipPoint<T>& into, const HullClipPoint<T>& point) noexcept {
  constexpr T near = T(2) * kSideTolerance<T>;
  if (!(std::abs(into.u - point.u) <= near && std::abs(into.v - point.v) <= near)) return false;
  const T w = std::min(into.w, point.w);
  if (point.id < into.id) into = point;
  into.w = w;
  return true;
}

// Keeps the best score seen; what beats it by less than the tolerance only if its id is lower.
template <class T>
struct Choice {
  const HullPolygon<T>& polygon;
  T tolerance;
  T score{};
  std::uint32_t index{kNone};
  static constexpr std::uint32_t kNone = 0xffffffffu;

  void offer(std::uint32_t i, T candidate) noexcept {
    if (index != kNone) {
      const bool better = candidate > score + tolerance;
      const bool equal = candidate >= score - tolerance && polygon.points[i].id < polygon.points[index].id;
      if (!better && !equal) return;
    }
    score = candidate, index = i;
  }
};

template <class T>
T squared(const HullClipPoint<T>& a, const HullClipPoint<T>& b) noexcept {
  return (b.u - a.u) * (b.u - a.u) + (b.v - a.v) * (b.v - a.v);
}

// Twice the signed area of the triangle.
template <class T>
T area(const HullClipPoint<T>& a, const HullClipPoint<T>& b, const HullClipPoint<T>& c) noexcept {
  return (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
}

}  // namespace

template <class T>
void clip_to_side(HullPolygon<T>& polygon, T nu, T nv, T limit, std::uint32_t side) noexcept {
  std::array<T, kMaxHullClipPoints> beyond;
  bool all_inside = true;
  for (std::uint32_t k = 0; k < polygon.count; ++k) {
    beyond[k] = nu * polygon.points[k].u + nv * polygon.points[k].v - limit;
    all_inside = all_inside && beyond[k] <= kSideTolerance<T>;
  }
  if (all_inside) return;
  HullPolygon<T> kept;
  for (std::uint32_t k = 0; k < polygon.count; ++k) {
    const std::uint32_t next = k + 1 == polygon.count ? 0 : k + 1;
    const bool inside = beyond[k] <= kSideTolerance<T>, next_inside = beyond[next] <= kSideTolerance<T>;
    if (inside) push(kept, polygon.points[k]);
    if (inside == next_inside) continue;
    HullClipPoint<T> point = crossing(polygon.points[k], polygon.points[next], beyond[k], beyond[next], side);
    if (inside) point.line = kFirstHullSide + side;  // from here the polygon follows the side
    push(kept, point);
  }
  polygon.count = kept.count;
  std::copy_n(kept.points.begin(), kept.count, polygon.points.begin());
}

template <class T>
void merge_neighbours(HullPolygon<T>& polygon) noexcept {
  std::uint32_t kept = 0;
  for (std::uint32_t k = 0; k < polygon.count; ++k)
    if (kept == 0 || !merge(polygon.points[kept - 1], polygon.points[k])) polygon.points[kept++] = polygon.points[k];
  if (kept > 1 && merge(polygon.points[0], polygon.points[kept - 1])) --kept;
  polygon.count = kept;
}

template <class T>
void reduce_to_four(HullPolygon<T>& polygon) noexcept {
  if (polygon.count <= 4) return;
  const auto& p = polygon.points;
  Choice<T> deepest{polygon, T(1e-6)};  // m: above the noise of a resting contact, a tenth of the solver's slop
  for (std::uint32_t i = 0; i < polygon.count; ++i) deepest.offer(i, -p[i].w);
  const std::uint32_t a = deepest.index;

  T span = T(0);
  for (std::uint32_t i = 0; i < polygon.count; ++i) span = std::max(span, squared(p[a], p[i]));
  Choice<T> farthest{polygon, T(1e-3) * span};
  for (std::uint32_t i = 0; i < polygon.count; ++i)
    if (i != a) farthest.offer(i, squared(p[a], p[i]));
  const std::uint32_t b = farthest.index;

  Choice<T> third{polygon, T(1e-3) * span};
  for (std::uint32_t i = 0; i < polygon.count; ++i)
    if (i != a && i != b) third.offer(i, std::abs(area(p[a], p[b], p[i])));
  const std::uint32_t c = third.index;

  // What adds most outside the triangle, across any of its sides.
  const T turn = area(p[a], p[b], p[c]) < T(0) ? T(-1) : T(1);
  Choice<T> fourth{polygon, T(1e-3) * span};
  for (std::uint32_t i = 0; i < polygon.count; ++i)
    if (i != a && i != b && i != c)
      fourth.offer(i, std::max({-turn * area(p[a], p[b], p[i]), -turn * area(p[b], p[c], p[i]),
                                -turn * area(p[c], p[a], p[i])}));

  // The choice of the deepest ignored noise; its depth is not lost.
  T lowest = p[a].w;
  for (std::uint32_t i = 0; i < polygon.count; ++i) lowest = std::min(lowest, p[i].w);
  const HullClipPoint<T> chosen[4] = {p[a], p[b], p[c], p[fourth.index]};
  std::copy_n(chosen, 4, polygon.points.begin());
  polygon.points[0].w = lowest;
  polygon.count = 4;
}

#define TACTUS_INSTANTIATE(T)                                                      \
  template void clip_to_side<T>(HullPolygon<T>&, T, T, T, std::uint32_t) noexcept; \
  template void merge_neighbours<T>(HullPolygon<T>&) noexcept;                     \
  template void reduce_to_four<T>(HullPolygon<T>&) noexcept;
TACTUS_INSTANTIATE(double)
TACTUS_INSTANTIATE(float)
#undef TACTUS_INSTANTIATE

}  // namespace tactus::physics
