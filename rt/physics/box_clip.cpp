#include "rt/physics/box_clip.h"

#include <algorithm>

namespace tactus::physics {
namespace {

template <class T>
void push(ClipPolygon<T>& polygon, const ClipPoint<T>& point) noexcept {
  // Never full in exact arithmetic; rounding may fold a sliver of a face once more, and that corner is no loss.
  if (polygon.count < kMaxClipPoints) polygon.points[polygon.count++] = point;
}

// What is beyond a side by no more than this stays as it is [m]: in a stack of equal boxes every corner lies on a
// side, and must not take turns between being a corner and a crossing. The solver's slop.
template <class T>
inline constexpr T kSideTolerance = T(1e-5);

// Where the line from `from` to `to` meets a side. `id`: of the line and the side together.
template <class T>
ClipPoint<T> crossing(const ClipPoint<T>& from, const ClipPoint<T>& to, T beyond_from, T beyond_to,
                      std::uint8_t side) noexcept {
  // Where the inner one is itself beyond the side, within the tolerance, the crossing is at the tolerance's end.
  const T shift = beyond_from <= T(0) || beyond_to <= T(0) ? T(0) : kSideTolerance<T>;
  const T ratio = (beyond_from - shift) / (beyond_from - beyond_to);
  const auto id = static_cast<std::uint8_t>(8 + from.line * 4 + (side - kFirstSide));
  return {from.u + ratio * (to.u - from.u), from.v + ratio * (to.v - from.v), from.w + ratio * (to.w - from.w), id,
          from.line};
}

// Keeps what has sign * coordinate <= limit, but for the tolerance.
template <class T>
void clip_to_side(ClipPolygon<T>& polygon, T ClipPoint<T>::*coordinate, T sign, T limit, std::uint8_t side) noexcept {
  std::array<T, kMaxClipPoints> beyond;
  bool all_inside = true;
  for (std::uint32_t k = 0; k < polygon.count; ++k) {
    beyond[k] = sign * (polygon.points[k].*coordinate) - limit;
    all_inside = all_inside && beyond[k] <= kSideTolerance<T>;
  }
  if (all_inside) return;
  ClipPolygon<T> kept;
  for (std::uint32_t k = 0; k < polygon.count; ++k) {
    const std::uint32_t next = k + 1 == polygon.count ? 0 : k + 1;
    const bool inside = beyond[k] <= kSideTolerance<T>, next_inside = beyond[next] <= kSideTolerance<T>;
    if (inside) push(kept, polygon.points[k]);
    if (inside == next_inside) continue;
    ClipPoint<T> point = crossing(polygon.points[k], polygon.points[next], beyond[k], beyond[next], side);
    if (inside) point.line = side;  // from here the polygon follows the side
    push(kept, point);
  }
  polygon = kept;
}

// A sliver of contact, as where two cards meet at their upper edges, is a line: of two neighbours that nearly coincide
// the lower id stays, with the depth of the deeper.
template <class T>
bool merge(ClipPoint<T>& into, const ClipPoint<T>& point) noexcept {
  constexpr T near = T(2) * kSideTolerance<T>;
  if (!(std::abs(into.u - point.u) <= near && std::abs(into.v - point.v) <= near)) return false;
  const T w = std::min(into.w, point.w);
  if (point.id < into.id) into = point;
  into.w = w;
  return true;
}

template <class T>
void merge_neighbours(ClipPolygon<T>& polygon) noexcept {
  std::uint32_t kept = 0;
  for (std::uint32_t k = 0; k < polygon.count; ++k)
    if (kept == 0 || !merge(polygon.points[kept - 1], polygon.points[k])) polygon.points[kept++] = polygon.points[k];
  if (kept > 1 && merge(polygon.points[0], polygon.points[kept - 1])) --kept;
  polygon.count = kept;
}

// Keeps the best score seen; what beats it by less than the tolerance only if its id is lower.
template <class T>
struct Choice {
  T tolerance;
  T score{};
  std::int32_t index{-1};

  void offer(const ClipPolygon<T>& polygon, std::uint32_t i, T candidate) noexcept {
    const bool better = candidate > score + tolerance;
    const bool equal = index >= 0 && candidate >= score - tolerance &&
                       polygon.points[i].id < polygon.points[static_cast<std::uint32_t>(index)].id;
    if (index >= 0 && !better && !equal) return;
    score = candidate, index = static_cast<std::int32_t>(i);
  }
};

// Twice the signed area of the triangle.
template <class T>
T area(const ClipPoint<T>& a, const ClipPoint<T>& b, const ClipPoint<T>& c) noexcept {
  return (b.u - a.u) * (c.v - a.v) - (b.v - a.v) * (c.u - a.u);
}

template <class T>
std::uint32_t deepest_of(const ClipPolygon<T>& polygon) noexcept {
  Choice<T> choice{T(1e-6)};  // m: above the noise of a resting contact, a tenth of the solver's slop
  for (std::uint32_t i = 0; i < polygon.count; ++i) choice.offer(polygon, i, -polygon.points[i].w);
  return static_cast<std::uint32_t>(choice.index);
}

template <class T>
std::uint32_t farthest_from(const ClipPolygon<T>& polygon, std::uint32_t from) noexcept {
  const ClipPoint<T>& a = polygon.points[from];
  std::array<T, kMaxClipPoints> distance;
  T largest = T(0);
  for (std::uint32_t i = 0; i < polygon.count; ++i) {
    const T du = polygon.points[i].u - a.u, dv = polygon.points[i].v - a.v;
    distance[i] = du * du + dv * dv;
    largest = std::max(largest, distance[i]);
  }
  Choice<T> choice{T(1e-3) * largest};
  for (std::uint32_t i = 0; i < polygon.count; ++i)
    if (i != from) choice.offer(polygon, i, distance[i]);
  return static_cast<std::uint32_t>(choice.index);
}

}  // namespace

template <class T>
void clip_to_rectangle(ClipPolygon<T>& polygon, T half_u, T half_v) noexcept {
  clip_to_side(polygon, &ClipPoint<T>::u, T(1), half_u, kFirstSide);
  clip_to_side(polygon, &ClipPoint<T>::u, T(-1), half_u, kFirstSide + 1);
  clip_to_side(polygon, &ClipPoint<T>::v, T(1), half_v, kFirstSide + 2);
  clip_to_side(polygon, &ClipPoint<T>::v, T(-1), half_v, kFirstSide + 3);
  merge_neighbours(polygon);
}

template <class T>
void reduce_to_four(ClipPolygon<T>& polygon) noexcept {
  if (polygon.count <= 4) return;
  const auto& p = polygon.points;
  const std::uint32_t a = deepest_of(polygon), b = farthest_from(polygon, a);
  const T span = (p[b].u - p[a].u) * (p[b].u - p[a].u) + (p[b].v - p[a].v) * (p[b].v - p[a].v);

  Choice<T> third{T(1e-3) * span};
  for (std::uint32_t i = 0; i < polygon.count; ++i)
    if (i != a && i != b) third.offer(polygon, i, std::abs(area(p[a], p[b], p[i])));
  const auto c = static_cast<std::uint32_t>(third.index);

  // What adds most outside the triangle, across any of its sides.
  const T turn = area(p[a], p[b], p[c]) < T(0) ? T(-1) : T(1);
  Choice<T> fourth{T(1e-3) * span};
  for (std::uint32_t i = 0; i < polygon.count; ++i) {
    if (i == a || i == b || i == c) continue;
    const T added =
        std::max({-turn * area(p[a], p[b], p[i]), -turn * area(p[b], p[c], p[i]), -turn * area(p[c], p[a], p[i])});
    fourth.offer(polygon, i, added);
  }
  ClipPolygon<T> chosen;
  for (const std::uint32_t i : {a, b, c, static_cast<std::uint32_t>(fourth.index)}) push(chosen, p[i]);
  // The choice of the deepest ignored noise; its depth is not lost.
  for (std::uint32_t i = 0; i < polygon.count; ++i) chosen.points[0].w = std::min(chosen.points[0].w, p[i].w);
  polygon = chosen;
}

#define TACTUS_INSTANTIATE(T)                                         \
  template void clip_to_rectangle<T>(ClipPolygon<T>&, T, T) noexcept; \
  template void reduce_to_four<T>(ClipPolygon<T>&) noexcept;
TACTUS_INSTANTIATE(double)
TACTUS_INSTANTIATE(float)
#undef TACTUS_INSTANTIATE

}  // namespace tactus::physics
