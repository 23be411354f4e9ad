// The kernels of sphere and capsule against a hull. The hull is B; they work in its frame and transform the result.
#include <algorithm>
#include <array>
#include <limits>

#include "rt/physics/collision/collide_hull.h"
#include "rt/physics/collision/hull_closest.h"
#include "rt/physics/collision/hull_pair.h"
#include "rt/physics/shapes/segments.h"

namespace tactus::physics {
namespace {

// Features of a capsule on a hull.
constexpr std::uint32_t kClosest = 0, kLowEnd = 1, kHighEnd = 2;

// Closest directions within 3 degrees of a face's normal count as the face's, as on a box.
inline constexpr double kFaceCosine = 0.9986;

// A capsule and a hull, in the hull's frame. The capsule's axis is centre + t half, t in [-1, 1].
struct CapsuleHull {
  const PairView& pair;
  const HullView& hull;
  Vec3d centre, half;
  double radius;

  Vec3d at(double t) const noexcept { return centre + half * t; }
  double height(std::uint32_t face, double t) const noexcept { return hull.height(face, at(t)); }
  void set_normal(Manifold& manifold, const Vec3d& outward) const noexcept {
    manifold.normal = -rotate(pair.world_from_b, outward);
  }
  void add(Manifold& manifold, const Vec3d& outward, double t, const Vec3d& on_hull, double separation,
           std::uint32_t feature) const noexcept {
    const Vec3d mid = 0.5 * (at(t) - outward * radius + on_hull);
    add_point(pair, manifold, pair.b_from_a + rotate(pair.world_from_b, mid), separation, feature);
  }
};

struct Nearest {
  double t{};  // axis parameter
  Vec3d on_hull;
  double squared{-1.0};
  std::uint32_t edge{kMaxHullEdges};  // the edge on which the point is; kMaxHullEdges for an end of the axis

  // Takes the candidate if it is nearer than `than` and than the nearest so far, or if it is the first.
  void offer(double t_offered, const Vec3d& on_axis, const Vec3d& point, std::uint32_t on_edge, double than) noexcept {
    const double offered = norm_squared(on_axis - point);
    if (squared >= 0.0 && !(offered < squared && offered < than)) return;
    t = t_offered;
    on_hull = point;
    squared = offered;
    edge = on_edge;
  }
};

using FaceMarks = std::array<bool, kMaxHullFaces>;

// Exact: the nearest point of an axis outside the hull is at one of its ends or over an edge. There the way from the
// hull to the axis is a sum of the normals of the edge's two faces with shares of 0 and more, so the point of the axis
// is above one of them; and a point of the axis is above a face only if one of its ends is.
Nearest nearest_outside(const CapsuleHull& c, const FaceMarks& above) noexcept {
  Nearest nearest;
  for (std::uint32_t e = 0; e < c.hull.topology->edges; ++e) {
    const HullEdge& edge = c.hull.topology->edge[e];
    if (!above[edge.left] && !above[edge.right]) continue;
    const Vec3d from = c.hull.vertex(edge.from), to = c.hull.vertex(edge.to);
    const Vec3d half = 0.5 * (to - from), middle = 0.5 * (from + to);
    const auto [s, t] = closest_on_segments(c.half, half, middle - c.centre);
    nearest.offer(s, c.at(s), middle + half * t, e, nearest.squared);
  }
  // Up to rounding, an end beside an edge is as near as the edge: then the edge is taken.
  const double nearer = nearest.squared * (1.0 - 16.0 * std::numeric_limits<double>::epsilon());
  for (const double t : {-1.0, 1.0}) nearest.offer(t, c.at(t), closest_on_hull(c.hull, c.at(t)), kMaxHullEdges, nearer);
  return nearest;
}

// Adds the part of the capsule above the face: two points, or one if it is short. Returns false if no part is above it.
// `bound`: the distance, or a bound of it; the gap of the nearer point is limited to it.
bool add_face_points(const CapsuleHull& c, Manifold& manifold, std::uint32_t face, double bound) noexcept {
  const LineRange range = range_above_face(c.hull, face, c.centre, c.half);
  if (range.empty()) return false;
  const Vec3d n = c.hull.normal(face);
  const double parameter[2] = {range.low, range.high};
  double separation[2] = {c.height(face, range.low) - c.radius, c.height(face, range.high) - c.radius};
  const int nearer = separation[1] < separation[0] ? 1 : 0;
  separation[nearer] = std::min(separation[nearer], bound);
  const bool one = (range.high - range.low) * norm(c.half) <= kFlatTolerance;
  c.set_normal(manifold, n);
  for (int k = 0; k < 2; ++k) {
    if (one && k != nearer) continue;
    const Vec3d on_hull = c.at(parameter[k]) - n * c.height(face, parameter[k]);
    c.add(manifold, n, parameter[k], on_hull, separation[k], one ? kClosest : k == 0 ? kLowEnd : kHighEnd);
  }
  return manifold.count > 0;
}

// Adds the part of the capsule along an edge: both its ends, if they are close enough to the edge for one normal to fit
// both.
bool add_edge_points(const CapsuleHull& c, Manifold& manifold, std::uint32_t e, const Vec3d& normal,
                     double bound) noexcept {
  const Vec3d from = c.hull.vertex(c.hull.topology->edge[e].from),
              along = c.hull.vertex(c.hull.topology->edge[e].to) - from;
  const double length_squared = norm_squared(along);
  LineRange range;
  cut_range(range, -dot(along, c.centre - from), -dot(along, c.half));
  cut_range(range, dot(along, c.centre - from) - length_squared, dot(along, c.half));
  if (range.empty() || !((range.high - range.low) * norm(c.half) > kFlatTolerance)) return false;
  const double parameter[2] = {range.low, range.high};
  Vec3d on_edge[2];
  double separation[2];
  for (int k = 0; k < 2; ++k) {
    const Vec3d p = c.at(parameter[k]);
    on_edge[k] = from + along * (dot(along, p - from) / length_squared);
    const double height = dot(p - on_edge[k], normal);
    if (!(norm(p - on_edge[k]) - height <= kFlatTolerance)) return false;
    separation[k] = height - c.radius;
  }
  const int nearer = separation[1] < separation[0] ? 1 : 0;
  separation[nearer] = std::min(separation[nearer], bound);
  c.set_normal(manifold, normal);
  for (int k = 0; k < 2; ++k)
    c.add(manifold, normal, parameter[k], on_edge[k], separation[k], k == 0 ? kLowEnd : kHighEnd);
  return manifold.count > 0;
}

void collide_outside(const CapsuleHull& c, Manifold& manifold, const Nearest& nearest, double distance) noexcept {
  const Vec3d normal = (c.at(nearest.t) - nearest.on_hull) * (1.0 / distance);
  const double separation = distance - c.radius;
  std::uint32_t face = 0;
  for (std::uint32_t f = 1; f < c.hull.topology->faces; ++f)
    if (dot(c.hull.normal(f), normal) > dot(c.hull.normal(face), normal)) face = f;
  if (dot(c.hull.normal(face), normal) > kFaceCosine && add_face_points(c, manifold, face, separation)) return;
  manifold = {};
  if (nearest.edge < kMaxHullEdges && add_edge_points(c, manifold, nearest.edge, normal, separation)) return;
  manifold = {};
  c.set_normal(manifold, normal);
  c.add(manifold, normal, nearest.t, nearest.on_hull, separation, kClosest);
}

// The axis intersects the hull between t = inside.low and inside.high: the normal is the direction of least
// penetration, among the faces and the pairs of the axis and an edge.
void collide_inside(const CapsuleHull& c, Manifold& manifold, const LineRange& inside) noexcept {
  const HullTopology& topology = *c.hull.topology;
  std::uint32_t face = 0;
  double face_separation = 0.0;
  for (std::uint32_t f = 0; f < topology.faces; ++f) {
    const double separation = std::min(c.height(f, -1.0), c.height(f, 1.0)) - c.radius;
    if (f == 0 || separation > face_separation) {
      face = f;
      face_separation = separation;
    }
  }
  std::uint32_t edge = kMaxHullEdges;
  double edge_separation = face_separation + axis_preference(face_separation);
  Vec3d edge_normal;
  for (std::uint32_t e = 0; e < topology.edges; ++e) {
    const HullEdge& candidate = topology.edge[e];
    // An edge can be the support along a direction normal to the capsule only if its faces' normals are on different
    // sides of the plane normal to the axis.
    if (!(dot(c.hull.normal(candidate.left), c.half) * dot(c.hull.normal(candidate.right), c.half) < 0.0)) continue;
    const Vec3d from = c.hull.vertex(candidate.from), along = c.hull.vertex(candidate.to) - from;
    const Vec3d w = cross(along, c.half);
    const double length = norm(w);
    if (!(length > 5e-3 * norm(c.half) * norm(along) && length > kNoDirection * norm(along))) continue;
    const Vec3d n = w * ((dot(w, from) < 0.0 ? -1.0 : 1.0) / length);
    const double separation = dot(n, c.centre - from) - c.radius;
    if (separation > edge_separation) {
      edge = e;
      edge_separation = separation;
      edge_normal = n;
    }
  }
  if (edge == kMaxHullEdges) {
    if (add_face_points(c, manifold, face, face_separation)) return;
    // No part is above the face: uses the middle of the part inside the hull.
    manifold = {};
    const double t = 0.5 * (inside.low + inside.high);
    c.set_normal(manifold, c.hull.normal(face));
    return c.add(manifold, c.hull.normal(face), t, c.at(t), face_separation, kClosest);
  }
  const Vec3d from = c.hull.vertex(topology.edge[edge].from), to = c.hull.vertex(topology.edge[edge].to);
  const Vec3d half = 0.5 * (to - from), middle = 0.5 * (from + to);
  const auto [s, t] = closest_on_segments(c.half, half, middle - c.centre);
  c.set_normal(manifold, edge_normal);
  c.add(manifold, edge_normal, s, middle + half * t, edge_separation, kClosest);
}

}  // namespace

void collide_sphere_hull(const PairView& pair, const HullView& hull, Manifold& manifold) noexcept {
  const double radius = pair.a.radius;
  const Vec3d centre = rotate_inverse(pair.world_from_b, -pair.b_from_a);
  const HighestFace highest = highest_face(hull, centre);
  if (!(highest.height - radius <= pair.margin)) return;
  Vec3d on_hull = closest_on_hull(hull, centre), normal = hull.normal(highest.face);
  double distance = norm(centre - on_hull);
  if (distance > kNoDirection)
    normal = (centre - on_hull) * (1.0 / distance);
  else  // the centre is inside: out through the nearest face
  {
    distance = highest.height;
    on_hull = centre - normal * distance;
  }
  manifold.normal = -rotate(pair.world_from_b, normal);
  const Vec3d mid = 0.5 * (centre - normal * radius + on_hull);
  add_point(pair, manifold, pair.b_from_a + rotate(pair.world_from_b, mid), distance - radius, 0);
}

void collide_capsule_hull(const PairView& pair, const HullView& hull, Manifold& manifold) noexcept {
  const CapsuleHull c{.pair = pair,
                      .hull = hull,
                      .centre = rotate_inverse(pair.world_from_b, -pair.b_from_a),
                      .half = rotate_inverse(pair.world_from_b, capsule_half_axis(pair.a, pair.world_from_a)),
                      .radius = pair.a.radius};
  LineRange inside;
  FaceMarks above;
  for (std::uint32_t f = 0; f < hull.topology->faces; ++f) {
    const double middle = dot(hull.normal(f), c.centre) - hull.offsets[f], slope = dot(hull.normal(f), c.half);
    if (!(middle - std::abs(slope) - c.radius <= pair.margin)) return;
    cut_range(inside, middle, slope);
    above[f] = middle + std::abs(slope) > 0.0;
  }
  if (!inside.empty()) return collide_inside(c, manifold, inside);
  const Nearest nearest = nearest_outside(c, above);
  const double distance = std::sqrt(nearest.squared);
  if (!(distance - c.radius <= pair.margin)) return;
  if (distance > kNoDirection) return collide_outside(c, manifold, nearest, distance);
  collide_inside(c, manifold, LineRange{nearest.t, nearest.t});
}

}  // namespace tactus::physics
