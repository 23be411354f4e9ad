// The kernels of spheres and capsules among themselves: closed form on the skeletons (centre, axis), radii added
// afterwards.
#include <algorithm>
#include <utility>

#include "rt/physics/collision/collide.h"
#include "rt/physics/shapes/segments.h"

namespace tactus::physics {
namespace {

// Features of a capsule pair.
constexpr std::uint32_t kClosest = 0, kLowEnd = 1, kHighEnd = 2;

// Normal where the axes intersect and give no direction: perpendicular to both, towards the other's centre.
Vec3d across(const Vec3d& half_a, const Vec3d& half_b, const Vec3d& offset) noexcept {
  const Vec3d axis_a = direction_or(half_a, Vec3d{0.0, 0.0, 1.0}), axis_b = direction_or(half_b, axis_a);
  const Vec3d n = direction_or(cross(axis_a, axis_b), tangents_of(axis_a).t1);
  return dot(n, offset) < 0.0 ? -n : n;
}

// The range in which the two axes are side by side: opposite points at both ends of the range, perpendicular to the
// longer axis, so that the order of the two does not matter.
struct SideBySide {
  bool found{false};
  Vec3d on_a[2], on_b[2];
};

SideBySide side_by_side(const Vec3d& half_a, const Vec3d& half_b, const Vec3d& offset) noexcept {
  if (dot(half_b, half_b) > dot(half_a, half_a)) {
    SideBySide swapped = side_by_side(half_b, half_a, -offset);
    for (int i = 0; i < 2; ++i) {
      const Vec3d on_b = swapped.on_a[i] + offset;
      swapped.on_a[i] = swapped.on_b[i] + offset;
      swapped.on_b[i] = on_b;
    }
    return swapped;
  }
  const double aa = dot(half_a, half_a), ab = dot(half_a, half_b);
  if (!(aa > kNoDirection) || !(std::abs(ab) > 0.5 * norm(half_b) * std::sqrt(aa))) return {};
  // In units of A's half length along A: A covers [-1, 1], B covers centre -+ span.
  const double centre = dot(half_a, offset) / aa, span = ab / aa;
  const double low = std::max(-1.0, centre - std::abs(span)), high = std::min(1.0, centre + std::abs(span));
  if (!((high - low) * std::sqrt(aa) > kFlatTolerance)) return {};
  SideBySide result{true, {}, {}};
  for (int i = 0; i < 2; ++i) {
    const double s = i == 0 ? low : high, t = std::clamp((s - centre) / span, -1.0, 1.0);
    result.on_a[i] = half_a * s;
    result.on_b[i] = offset + half_b * t;
  }
  return result;
}

}  // namespace

void collide_sphere_sphere(const PairView& pair, Manifold& manifold) noexcept {
  const double separation = norm(pair.b_from_a) - pair.a.radius - pair.b.radius;
  if (!(separation <= pair.margin)) return;
  manifold.normal = direction_or(pair.b_from_a, Vec3d{0.0, 0.0, 1.0});
  add_round_point(pair, manifold, {{}, pair.a.radius}, {pair.b_from_a, pair.b.radius}, separation, 0);
}

void collide_sphere_capsule(const PairView& pair, Manifold& manifold) noexcept {
  const Vec3d half = capsule_half_axis(pair.b, pair.world_from_b);
  const double t = closest_on_segments(Vec3d{}, half, pair.b_from_a).t;
  const Vec3d on_b = pair.b_from_a + half * t;
  const double separation = norm(on_b) - pair.a.radius - pair.b.radius;
  if (!(separation <= pair.margin)) return;
  manifold.normal = direction_or(on_b, across(half, half, pair.b_from_a));
  add_round_point(pair, manifold, {{}, pair.a.radius}, {on_b, pair.b.radius}, separation, 0);
}

// Two points if the axes are side by side and flat enough for one normal to fit both ends of the range; the gap between
// is no smaller than at the ends. Otherwise only the closest point: crossing capsules touch in one.
void collide_capsule_capsule(const PairView& pair, Manifold& manifold) noexcept {
  const Vec3d half_a = capsule_half_axis(pair.a, pair.world_from_a),
              half_b = capsule_half_axis(pair.b, pair.world_from_b);
  const auto [s, t] = closest_on_segments(half_a, half_b, pair.b_from_a);
  const Vec3d on_a = half_a * s, on_b = pair.b_from_a + half_b * t, gap = on_b - on_a;
  const double radii = pair.a.radius + pair.b.radius, separation = norm(gap) - radii;
  if (!(separation <= pair.margin)) return;
  const Vec3d n = manifold.normal = direction_or(gap, across(half_a, half_b, pair.b_from_a));

  const SideBySide ends = side_by_side(half_a, half_b, pair.b_from_a);
  double along[2] = {0.0, 0.0};
  bool flat = ends.found;
  for (int i = 0; i < 2 && flat; ++i) {
    const Vec3d between = ends.on_b[i] - ends.on_a[i];
    along[i] = dot(n, between);
    flat = norm(between) - along[i] <= kFlatTolerance;
  }
  if (!flat) {
    add_round_point(pair, manifold, {on_a, pair.a.radius}, {on_b, pair.b.radius}, separation, kClosest);
    return;
  }
  // The nearer end gets the exact distance, so that no gap is larger than the true one.
  const int nearer = along[1] < along[0] ? 1 : 0;
  along[nearer] = std::min(along[nearer], separation + radii);
  for (int i = 0; i < 2; ++i)
    add_round_point(pair, manifold, {ends.on_a[i], pair.a.radius}, {ends.on_b[i], pair.b.radius}, along[i] - radii,
                    i == 0 ? kLowEnd : kHighEnd);
}

}  // namespace tactus::physics
