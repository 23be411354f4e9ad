// Internal interface of narrow phase: the input of the pair kernels, and the kernels. Other code uses manifold.h.
//
// Frame: world axes, origin at the centre of A, so that positions far from the world's origin lose no precision. Units:
// m. Thread: [any]; pure, bounded, no allocation. A kernel fills the manifold of a pair whose kinds are in the order of
// ShapeKind; the dispatcher mirrors the other pairs. A kernel leaves count 0 if nothing is within the margin, and if a
// pose is not finite: every test is written so that a NaN fails it.
#pragma once

#include <limits>

#include "rt/base/wide.h"
#include "rt/physics/body_frame.h"
#include "rt/physics/collision/manifold.h"

namespace tactus::physics {

struct PairView {
  const Shape& a;
  const Shape& b;
  const Quatd& world_from_a;
  const Quatd& world_from_b;
  Vec3d b_from_a;  // m, from the centre of A to the centre of B, world axes
  double margin;   // m
  const LastFeatures& last;
  AxisCache apart{};  // of the last step
};

inline PairView pair_view(PosedShape a, PosedShape b, const ManifoldQuery& query) noexcept {
  return {.a = a.shape,
          .b = b.shape,
          .world_from_a = a.pose.rotation,
          .world_from_b = b.pose.rotation,
          .b_from_a = b.pose.position - a.pose.position,
          .margin = query.margin,
          .last = query.last,
          .apart = query.apart};
}

// Marks the polygon's points that were in the last step's manifold. `type`: the type bits that their ids lack to be
// features.
template <class Polygon>
void mark_kept(const PairView& pair, std::uint32_t type, Polygon& polygon) noexcept {
  for (std::uint32_t k = 0; k < polygon.count; ++k) polygon.points[k].kept = pair.last.has(type | polygon.points[k].id);
}

// Distance below which two points define no direction [m]: far above rounding at arm's length, far below any shape.
inline constexpr double kNoDirection = 1e-12;

// Largest error of a capsule's end point when a two-point contact replaces the exact one [m]: the solver's slop (10
// um), an overlap that is not corrected anyway.
inline constexpr double kFlatTolerance = 1e-5;

// Overlap or gap of two surfaces up to which they count as flush [m]: a body that slides along one passes over the
// other, without a contact with its edge. A resting contact is a few um deep, and an edge that is higher by so little
// must not stop a body.
inline constexpr double kFlush = 1e-4;
// Cosines: the normal of a flush face and that of a contact with its edge are across each other below the first, and
// may come to be below it, while the contact is carried over, below the second.
inline constexpr double kAcross = 0.5, kAcrossCarried = 0.55;

// --- features and axes of boxes and hulls
// The two top bits of a feature: its type (see is_of_face).
inline constexpr std::uint32_t kClosestType = 0u, kFaceAType = 1u << 30, kFaceBType = 2u << 30, kEdgeType = 3u << 30;

// Square of the sine of 0.3 degrees: edges closer to parallel give no usable contact normal, and the face axes cover
// them.
inline constexpr double kParallelSineSquared = 2.5e-5;

// An axis must beat the preferred one by 5 % and 10 um (the solver's slop): far above noise, too little to be felt.
inline double axis_preference(double separation) noexcept { return 0.05 * std::abs(separation) + 1e-5; }

// Does an axis of two edges (of any length) point along a face's unit normal, within 8 degrees?
inline bool is_along_face(const Vec3d& edge_axis, const Vec3d& face_normal) noexcept {
  const double along = dot(edge_axis, face_normal);
  return along * along > 0.98 * norm_squared(edge_axis);
}

// Amount by which an axis of two edges must beat a face. Along the face's normal, the face gives nearly the same
// contact with more points, and a stack whose contacts alternate between the two never comes to rest: there the
// preference is ten times as large, so the face may be twice as deep (with five times, a heap of 1,000 cubes at 10 ms
// did not come to rest, 2026-11-22). An edge contact of the last step needs only half of the preference.
inline double edge_preference(double face_separation, bool along_face, bool last) noexcept {
  return axis_preference(face_separation) * (along_face ? 10.0 : last ? 0.5 : 1.0);
}

// Gives a clipped face the normal of two edges that cross nearly along the face's normal: `cosine` of the angle between
// the two. A single point where the edges cross would leave the rest of the face free, and a card that turns by 20
// rad/s moves its far corner by 2 mm in a millisecond. Height times cosine is the separation of the edges at their
// crossing, and for all other points a lower bound of the distance along the normal. False if the crossing, at
// `separation`, is not the polygon's lowest point: then the polygon is unchanged, and the edges do not meet above this
// face.
template <class Polygon>
bool tilt_to_edges(double cosine, double separation, Polygon& polygon) noexcept {
  double lowest = std::numeric_limits<double>::infinity();
  for (std::uint32_t k = 0; k < polygon.count; ++k) lowest = smaller(lowest, cosine * polygon.points[k].w);
  if (!(std::abs(lowest - separation) <= axis_preference(separation))) return false;
  for (std::uint32_t k = 0; k < polygon.count; ++k) polygon.points[k].w *= cosine;
  return true;
}

inline Vec3d direction_or(const Vec3d& v, const Vec3d& fallback) noexcept {
  const double length = norm(v);
  return length > kNoDirection ? v * (1.0 / length) : fallback;
}

// `mid`: midway between the surfaces, from the centre of A.
inline void add_point(const PairView& pair, Manifold& manifold, const Vec3d& mid, double separation,
                      std::uint32_t feature) noexcept {
  if (!(separation <= pair.margin) || manifold.count == kMaxManifoldPoints) return;
  manifold.points[manifold.count++] = {
      .from_a = mid, .from_b = mid - pair.b_from_a, .separation = separation, .feature = feature};
}

// Keeps the points for which `is_kept` is true, in their order.
template <class IsKept>
void keep_points(IsKept is_kept, Manifold& manifold) noexcept {
  std::uint32_t kept = 0;
  for (std::uint32_t i = 0; i < manifold.count; ++i)
    if (is_kept(manifold.points[i])) manifold.points[kept++] = manifold.points[i];
  manifold.count = kept;
}

// Keeps the points whose separation is at most the margin [m].
inline void drop_points_beyond(double margin, Manifold& manifold) noexcept {
  keep_points([margin](const ManifoldPoint& point) noexcept { return point.separation <= margin; }, manifold);
}

// A point on the skeleton of a round shape (centre, axis) and the radius around it; 0 for a box.
struct SkeletonPoint {
  Vec3d at;
  double radius;
};

// Adds the point between two round surfaces.
inline void add_round_point(const PairView& pair, Manifold& manifold, const SkeletonPoint& on_a,
                            const SkeletonPoint& on_b, double separation, std::uint32_t feature) noexcept {
  const Vec3d surface_a = on_a.at + manifold.normal * on_a.radius, surface_b = on_b.at - manifold.normal * on_b.radius;
  add_point(pair, manifold, 0.5 * (surface_a + surface_b), separation, feature);
}

// Half of the capsule's axis in the world: its ends are at centre -+ half.
inline Vec3d capsule_half_axis(const Shape& capsule, const Quatd& world_from_body) noexcept {
  return rotate(world_from_body, Vec3d{0.0, 0.0, capsule.half_length});
}

// Fills the gap of a pair that is apart: `gap`, a lower bound of its distance along one direction. The direction stays
// as it is in the world, so that a rotation moves a surface point by at most the body's radius times the angle. Only
// for kernels that find no point at any larger distance than the margin: then skipping the pair while its gap exceeds
// the margin does not change a result.
inline void report_gap(const PairView& pair, double gap, Manifold& manifold) noexcept {
  const double radius = larger(bounding_radius(pair.a), bounding_radius(pair.b));
  constexpr double rounding = 64.0 * std::numeric_limits<double>::epsilon();
  manifold.gap = smaller(gap, kLargestGap) - rounding * (radius + norm(pair.b_from_a));
  manifold.lever_arm = radius;
}

void collide_sphere_sphere(const PairView& pair, Manifold& manifold) noexcept;
void collide_sphere_capsule(const PairView& pair, Manifold& manifold) noexcept;
void collide_capsule_capsule(const PairView& pair, Manifold& manifold) noexcept;
void collide_sphere_plane(const PairView& pair, Manifold& manifold) noexcept;
void collide_capsule_plane(const PairView& pair, Manifold& manifold) noexcept;
void collide_box_plane(const PairView& pair, Manifold& manifold) noexcept;
void collide_sphere_box(const PairView& pair, Manifold& manifold) noexcept;
void collide_capsule_box(const PairView& pair, Manifold& manifold) noexcept;
void collide_box_box(const PairView& pair, Manifold& manifold, AxisCache& cache) noexcept;

}  // namespace tactus::physics
