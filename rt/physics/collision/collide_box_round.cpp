// The kernels of sphere and capsule against a box. The box is B; they work in the box's frame and transform the result.
#include <algorithm>

#include "rt/physics/collision/collide.h"
#include "rt/physics/shapes/segments.h"

namespace tactus::physics {
namespace {

// Features of a capsule on a box.
constexpr std::uint32_t kClosest = 0, kLowEnd = 1, kHighEnd = 2;

// Closest directions within 3 degrees of a face's normal count as the face's: a beam that lies on a face and overhangs
// its edge keeps its two points when it tips slightly.
inline constexpr double kFaceCosine = 0.9986;

Vec3d clamp_to_box(const Vec3d& point, const Vec3d& h) noexcept {
  return {std::clamp(point.x, -h.x, h.x), std::clamp(point.y, -h.y, h.y), std::clamp(point.z, -h.z, h.z)};
}

Vec3d unit_axis(int i, double sign) noexcept {
  Vec3d axis;
  axis[i] = sign;
  return axis;
}

double sign_of(double value) noexcept { return value < 0.0 ? -1.0 : 1.0; }

// A capsule and a box, in the box's frame. The capsule's axis is centre + t half, t in [-1, 1].
struct CapsuleBox {
  const PairView& pair;
  Vec3d centre, half, h;
  double radius;

  Vec3d at(double t) const noexcept { return centre + half * t; }
};

struct Range {
  double low{-1.0}, high{1.0};
};

// The part of the axis between the box's two faces across axis `i`.
Range clip_to_slab(const CapsuleBox& c, int i, Range range) noexcept {
  const double slope = c.half[i], inverse = 1.0 / slope;
  if (!(std::abs(slope) > kNoDirection)) return std::abs(c.centre[i]) <= c.h[i] ? range : Range{1.0, -1.0};
  const double t0 = (-c.h[i] - c.centre[i]) * inverse, t1 = (c.h[i] - c.centre[i]) * inverse;
  return {std::max(range.low, std::min(t0, t1)), std::min(range.high, std::max(t0, t1))};
}

// Half the derivative along the axis of the squared distance to the box: monotone, linear between the crossings of the
// six face planes.
double slope_of_distance(const CapsuleBox& c, double t) noexcept {
  const Vec3d p = c.at(t);
  return dot(p - clamp_to_box(p, c.h), c.half);
}

// The axis parameter nearest to the box: exact, by bracketing the zero of the derivative between the six crossings.
double closest_parameter(const CapsuleBox& c) noexcept {
  double low = -1.0, high = 1.0, slope_low = slope_of_distance(c, low), slope_high = slope_of_distance(c, high);
  if (slope_low >= 0.0) return low;
  if (slope_high <= 0.0) return high;
  for (int i = 0; i < 3; ++i) {
    for (const double side : {-1.0, 1.0}) {
      const double t = (side * c.h[i] - c.centre[i]) / c.half[i];
      if (!(t > low && t < high)) continue;  // also if the axis is parallel to the face
      const double slope = slope_of_distance(c, t);
      if (slope < 0.0) {
        low = t;
        slope_low = slope;
      } else {
        high = t;
        slope_high = slope;
      }
    }
  }
  return low + (high - low) * (-slope_low / (slope_high - slope_low));
}

// A point of the capsule's axis and the point of the box that it touches.
struct AxisPoint {
  double t;
  Vec3d on_box;       // box frame
  double separation;  // m, of the surfaces
};

// `normal`: box frame, from the box to the capsule.
void add_capsule_point(const CapsuleBox& c, Manifold& manifold, const Vec3d& normal, const AxisPoint& point,
                       std::uint32_t feature) noexcept {
  const Vec3d mid = 0.5 * (c.at(point.t) - normal * c.radius + point.on_box);
  add_point(c.pair, manifold, c.pair.b_from_a + rotate(c.pair.world_from_b, mid), point.separation, feature);
}

void set_normal(const CapsuleBox& c, Manifold& manifold, const Vec3d& normal) noexcept {
  manifold.normal = -rotate(c.pair.world_from_b, normal);
}

// Adds the part of the capsule above face `i`: two points, or one if it is short. Returns false if no part is above it.
// `nearest`: a known bound of the distance; the gap of the nearer point is limited to it.
bool add_face_points(const CapsuleBox& c, Manifold& manifold, int i, double sign, double nearest) noexcept {
  const Range range = clip_to_slab(c, (i + 2) % 3, clip_to_slab(c, (i + 1) % 3, Range{}));
  if (!(range.low <= range.high)) return false;
  const Vec3d normal = unit_axis(i, sign);
  double separation[2] = {sign * c.at(range.low)[i] - c.h[i] - c.radius,
                          sign * c.at(range.high)[i] - c.h[i] - c.radius};
  const int nearer = separation[1] < separation[0] ? 1 : 0;
  separation[nearer] = std::min(separation[nearer], nearest);
  const bool one = (range.high - range.low) * norm(c.half) <= kFlatTolerance;
  set_normal(c, manifold, normal);
  for (int k = 0; k < 2; ++k) {
    if (one && k != nearer) continue;
    const double t = k == 0 ? range.low : range.high;
    Vec3d on_box = c.at(t);
    on_box[i] = sign * c.h[i];
    const std::uint32_t feature = one ? kClosest : k == 0 ? kLowEnd : kHighEnd;
    add_capsule_point(c, manifold, normal, {.t = t, .on_box = on_box, .separation = separation[k]}, feature);
  }
  return true;
}

// Adds the part of the capsule along the box's edge in direction `j`: both its ends, if they are close enough to the
// edge for one normal to fit both.
bool add_edge_points(const CapsuleBox& c, Manifold& manifold, int j, const Vec3d& normal) noexcept {
  const Range range = clip_to_slab(c, j, Range{});
  if (!((range.high - range.low) * norm(c.half) > kFlatTolerance)) return false;
  const double parameters[2] = {range.low, range.high};
  Vec3d on_box[2];
  double along[2] = {0.0, 0.0};
  for (int k = 0; k < 2; ++k) {
    const Vec3d p = c.at(parameters[k]);
    on_box[k] = clamp_to_box(p, c.h);
    const Vec3d gap = p - on_box[k];
    along[k] = dot(gap, normal);
    if (!(norm(gap) - along[k] <= kFlatTolerance)) return false;
  }
  set_normal(c, manifold, normal);
  for (int k = 0; k < 2; ++k)
    add_capsule_point(c, manifold, normal, {.t = parameters[k], .on_box = on_box[k], .separation = along[k] - c.radius},
                      k == 0 ? kLowEnd : kHighEnd);
  return true;
}

// The axis is outside the box: the normal is the direction between the closest points.
void collide_outside(const CapsuleBox& c, Manifold& manifold, double t, const Vec3d& gap, double distance) noexcept {
  const Vec3d normal = gap * (1.0 / distance);
  const double separation = distance - c.radius;
  int inside_slabs = 0, edge = 0;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(normal[i]) > kFaceCosine && add_face_points(c, manifold, i, sign_of(normal[i]), separation)) return;
    if (gap[i] == 0.0) {
      ++inside_slabs;
      edge = i;
    }
  }
  if (inside_slabs == 1 && add_edge_points(c, manifold, edge, normal)) {
    // Limits the gap of the nearer point to the exact distance.
    if (manifold.count > 0) {
      auto& nearer =
          manifold.points[manifold.count == 2 && manifold.points[1].separation < manifold.points[0].separation];
      nearer.separation = std::min(nearer.separation, separation);
    }
    return;
  }
  set_normal(c, manifold, normal);
  add_capsule_point(c, manifold, normal, {.t = t, .on_box = c.at(t) - gap, .separation = separation}, kClosest);
}

// The axis intersects the box: the normal is the direction of least penetration among three face and three edge
// directions.
void collide_inside(const CapsuleBox& c, Manifold& manifold, double t_closest) noexcept {
  int face = 0;
  double face_separation = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double separation = std::abs(c.centre[i]) - std::abs(c.half[i]) - c.h[i] - c.radius;
    if (i == 0 || separation > face_separation) {
      face = i;
      face_separation = separation;
    }
  }
  int edge = -1;
  double edge_separation = face_separation + axis_preference(face_separation);
  Vec3d edge_normal;
  for (int j = 0; j < 3; ++j) {
    const Vec3d w = cross(unit_axis(j, 1.0), c.half);
    const double length = norm(w);
    if (!(length > 5e-3 * norm(c.half) && length > kNoDirection)) continue;
    Vec3d n = w * (1.0 / length);
    if (dot(n, c.centre) < 0.0) n = -n;
    const double separation = dot(n, c.centre) - dot(abs(n), c.h) - c.radius;
    if (separation > edge_separation) {
      edge = j;
      edge_separation = separation;
      edge_normal = n;
    }
  }
  if (edge < 0) {
    const double sign = sign_of(c.centre[face]);
    if (add_face_points(c, manifold, face, sign, 0.0)) return;
    // Rounding left the range empty: uses the axis point that was found inside the box.
    set_normal(c, manifold, unit_axis(face, sign));
    return add_capsule_point(c, manifold, unit_axis(face, sign),
                             {.t = t_closest, .on_box = c.at(t_closest), .separation = face_separation}, kClosest);
  }
  Vec3d edge_centre{sign_of(edge_normal.x) * c.h.x, sign_of(edge_normal.y) * c.h.y, sign_of(edge_normal.z) * c.h.z};
  edge_centre[edge] = 0.0;
  const Vec3d edge_half = unit_axis(edge, c.h[edge]);
  const auto [s, t] = closest_on_segments(c.half, edge_half, edge_centre - c.centre);
  set_normal(c, manifold, edge_normal);
  add_capsule_point(c, manifold, edge_normal,
                    {.t = s, .on_box = edge_centre + edge_half * t, .separation = edge_separation}, kClosest);
}

}  // namespace

void collide_sphere_box(const PairView& pair, Manifold& manifold) noexcept {
  const Vec3d& h = pair.b.half_extents;
  const Vec3d centre = rotate_inverse(pair.world_from_b, -pair.b_from_a);
  Vec3d on_box = clamp_to_box(centre, h), normal;
  const Vec3d gap = centre - on_box;
  double distance = norm(gap);
  if (!(distance - pair.a.radius <= pair.margin)) return;
  if (distance > kNoDirection) {
    normal = gap * (1.0 / distance);
  } else {  // the centre is inside: out through the nearest face, the lower axis on a tie
    const Vec3d depth = h - abs(centre);
    int face = 0;
    for (int i = 1; i < 3; ++i)
      if (depth[i] < depth[face]) face = i;
    normal = unit_axis(face, sign_of(centre[face]));
    on_box = centre;
    on_box[face] = normal[face] * h[face];
    distance = -depth[face];
  }
  manifold.normal = -rotate(pair.world_from_b, normal);
  const Vec3d mid = 0.5 * (centre - normal * pair.a.radius + on_box);
  add_point(pair, manifold, pair.b_from_a + rotate(pair.world_from_b, mid), distance - pair.a.radius, 0);
}

void collide_capsule_box(const PairView& pair, Manifold& manifold) noexcept {
  const CapsuleBox c{.pair = pair,
                     .centre = rotate_inverse(pair.world_from_b, -pair.b_from_a),
                     .half = rotate_inverse(pair.world_from_b, capsule_half_axis(pair.a, pair.world_from_a)),
                     .h = pair.b.half_extents,
                     .radius = pair.a.radius};
  const double t = closest_parameter(c);
  const Vec3d p = c.at(t), gap = p - clamp_to_box(p, c.h);
  const double distance = norm(gap);
  if (!(distance - c.radius <= pair.margin)) return;
  if (distance > kNoDirection)
    collide_outside(c, manifold, t, gap, distance);
  else
    collide_inside(c, manifold, t);
}

}  // namespace tactus::physics
