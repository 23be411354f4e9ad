// Sphere and capsule against a hull. The hull is B; the work is done in its frame and turned back at the end.
#include <algorithm>
#include <limits>

#include "rt/physics/collision/collide_hull.h"
#include "rt/physics/collision/hull_closest.h"
#include "rt/physics/collision/hull_pair.h"
#include "rt/physics/shapes/segments.h"

namespace tactus::physics {
namespace {

// Features of a capsule on a hull.
constexpr std::uint32_t kClosest = 0, kLowEnd = 1, kHighEnd = 2;

// A closest direction within 3 degrees of a face's normal counts as that face, as on a box.
template <class T>
inline constexpr T kFaceCosine = T(0.9986);

// Everything about a capsule and a hull, in the hull's frame. The axis is centre + t half, t in [-1, 1].
template <class T>
struct CapsuleHull {
  const PairView<T>& pair;
  const HullView<T>& hull;
  Vec3<T> centre, half;
  T radius;

  Vec3<T> at(T t) const noexcept { return centre + half * t; }
  T height(std::uint32_t face, T t) const noexcept { return dot(hull.normals[face], at(t)) - hull.offsets[face]; }
  void set_normal(Manifold<T>& manifold, const Vec3<T>& outward) const noexcept {
    manifold.normal = -rotate(pair.world_from_b, outward);
  }
  void add(Manifold<T>& manifold, const Vec3<T>& outward, T t, const Vec3<T>& on_hull, T separation,
           std::uint32_t feature) const noexcept {
    const Vec3<T> mid = T(0.5) * (at(t) - outward * radius + on_hull);
    add_point(pair, manifold, pair.b_from_a + rotate(pair.world_from_b, mid), separation, feature);
  }
};

template <class T>
struct Nearest {
  T t{};  // on the axis
  Vec3<T> on_hull;
  T squared{T(-1)};
  std::uint32_t edge{kMaxHullEdges};  // that it is on, where it is not an end's

  // Taken where it is nearer than `than` and than the nearest so far, or the first.
  void offer(T t_offered, const Vec3<T>& on_axis, const Vec3<T>& point, std::uint32_t on_edge, T than) noexcept {
    const T offered = norm_squared(on_axis - point);
    if (squared >= T(0) && !(offered < squared && offered < than)) return;
    t = t_offered, on_hull = point, squared = offered, edge = on_edge;
  }
};

// Exact: an axis outside the hull is nearest at an end or over an edge.
template <class T>
Nearest<T> nearest_outside(const CapsuleHull<T>& c) noexcept {
  Nearest<T> nearest;
  for (std::uint32_t e = 0; e < c.hull.topology->edges; ++e) {
    const HullEdge& edge = c.hull.topology->edge[e];
    const Vec3<T> from = c.hull.vertex(edge.from), to = c.hull.vertex(edge.to);
    const Vec3<T> half = T(0.5) * (to - from), middle = T(0.5) * (from + to);
    const auto [s, t] = closest_on_segments(c.half, half, middle - c.centre);
    nearest.offer(s, c.at(s), middle + half * t, e, nearest.squared);
  }
  // An end beside an edge is as near as the edge, but for rounding: then it is the edge that counts.
  const T nearer = nearest.squared * (T(1) - T(16) * std::numeric_limits<T>::epsilon());
  for (const T t : {T(-1), T(1)}) nearest.offer(t, c.at(t), closest_on_hull(c.hull, c.at(t)), kMaxHullEdges, nearer);
  return nearest;
}

// The stretch of the capsule above the face: two points, or one where it is short. False where there is none.
// `bound`: the distance, or a bound of it; the nearer point never reports a larger gap.
template <class T>
bool add_face_points(const CapsuleHull<T>& c, Manifold<T>& manifold, std::uint32_t face, T bound) noexcept {
  const LineRange<T> range = range_above_face(c.hull, face, c.centre, c.half);
  if (range.empty()) return false;
  const Vec3<T>& n = c.hull.normals[face];
  const T parameter[2] = {range.low, range.high};
  T separation[2] = {c.height(face, range.low) - c.radius, c.height(face, range.high) - c.radius};
  const int nearer = separation[1] < separation[0] ? 1 : 0;
  separation[nearer] = std::min(separation[nearer], bound);
  const bool one = (range.high - range.low) * norm(c.half) <= kFlatTolerance<T>;
  c.set_normal(manifold, n);
  for (int k = 0; k < 2; ++k) {
    if (one && k != nearer) continue;
    const Vec3<T> on_hull = c.at(parameter[k]) - n * c.height(face, parameter[k]);
    c.add(manifold, n, parameter[k], on_hull, separation[k], one ? kClosest : k == 0 ? kLowEnd : kHighEnd);
  }
  return manifold.count > 0;
}

// The stretch of the capsule that runs along an edge: both its ends, if they are so flat against it that one normal
// fits both.
template <class T>
bool add_edge_points(const CapsuleHull<T>& c, Manifold<T>& manifold, std::uint32_t e, const Vec3<T>& normal,
                     T bound) noexcept {
  const Vec3<T> from = c.hull.vertex(c.hull.topology->edge[e].from),
                along = c.hull.vertex(c.hull.topology->edge[e].to) - from;
  const T length_squared = norm_squared(along);
  LineRange<T> range;
  cut_range(range, -dot(along, c.centre - from), -dot(along, c.half));
  cut_range(range, dot(along, c.centre - from) - length_squared, dot(along, c.half));
  if (range.empty() || !((range.high - range.low) * norm(c.half) > kFlatTolerance<T>)) return false;
  const T parameter[2] = {range.low, range.high};
  Vec3<T> on_edge[2];
  T separation[2];
  for (int k = 0; k < 2; ++k) {
    const Vec3<T> p = c.at(parameter[k]);
    on_edge[k] = from + along * (dot(along, p - from) / length_squared);
    const T height = dot(p - on_edge[k], normal);
    if (!(norm(p - on_edge[k]) - height <= kFlatTolerance<T>)) return false;
    separation[k] = height - c.radius;
  }
  const int nearer = separation[1] < separation[0] ? 1 : 0;
  separation[nearer] = std::min(separation[nearer], bound);
  c.set_normal(manifold, normal);
  for (int k = 0; k < 2; ++k)
    c.add(manifold, normal, parameter[k], on_edge[k], separation[k], k == 0 ? kLowEnd : kHighEnd);
  return manifold.count > 0;
}

template <class T>
void collide_outside(const CapsuleHull<T>& c, Manifold<T>& manifold, const Nearest<T>& nearest, T distance) noexcept {
  const Vec3<T> normal = (c.at(nearest.t) - nearest.on_hull) * (T(1) / distance);
  const T separation = distance - c.radius;
  std::uint32_t face = 0;
  for (std::uint32_t f = 1; f < c.hull.topology->faces; ++f)
    if (dot(c.hull.normals[f], normal) > dot(c.hull.normals[face], normal)) face = f;
  if (dot(c.hull.normals[face], normal) > kFaceCosine<T> && add_face_points(c, manifold, face, separation)) return;
  manifold = {};
  if (nearest.edge < kMaxHullEdges && add_edge_points(c, manifold, nearest.edge, normal, separation)) return;
  manifold = {};
  c.set_normal(manifold, normal);
  c.add(manifold, normal, nearest.t, nearest.on_hull, separation, kClosest);
}

// The axis meets the hull, between t = inside.low and .high: the direction that needs the least push, among faces and
// pairs of the axis and an edge.
template <class T>
void collide_inside(const CapsuleHull<T>& c, Manifold<T>& manifold, const LineRange<T>& inside) noexcept {
  const HullTopology& topology = *c.hull.topology;
  std::uint32_t face = 0;
  T face_separation = T(0);
  for (std::uint32_t f = 0; f < topology.faces; ++f) {
    const T separation = std::min(c.height(f, T(-1)), c.height(f, T(1))) - c.radius;
    if (f == 0 || separation > face_separation) face = f, face_separation = separation;
  }
  std::uint32_t edge = kMaxHullEdges;
  T edge_separation = face_separation + axis_preference(face_separation);
  Vec3<T> edge_normal;
  for (std::uint32_t e = 0; e < topology.edges; ++e) {
    const HullEdge& candidate = topology.edge[e];
    // An edge supports an axis across the capsule just where its faces' normals are on either side of that plane.
    if (!(dot(c.hull.normals[candidate.left], c.half) * dot(c.hull.normals[candidate.right], c.half) < T(0))) continue;
    const Vec3<T> from = c.hull.vertex(candidate.from), along = c.hull.vertex(candidate.to) - from;
    const Vec3<T> w = cross(along, c.half);
    const T length = norm(w);
    if (!(length > T(5e-3) * norm(c.half) * norm(along) && length > kNoDirection<T> * norm(along))) continue;
    const Vec3<T> n = w * ((dot(w, from) < T(0) ? T(-1) : T(1)) / length);
    const T separation = dot(n, c.centre - from) - c.radius;
    if (separation > edge_separation) edge = e, edge_separation = separation, edge_normal = n;
  }
  if (edge == kMaxHullEdges) {
    if (add_face_points(c, manifold, face, face_separation)) return;
    // The stretch above the face is empty: the middle of what is inside stands for it.
    manifold = {};
    const T t = T(0.5) * (inside.low + inside.high);
    c.set_normal(manifold, c.hull.normals[face]);
    return c.add(manifold, c.hull.normals[face], t, c.at(t), face_separation, kClosest);
  }
  const Vec3<T> from = c.hull.vertex(topology.edge[edge].from), to = c.hull.vertex(topology.edge[edge].to);
  const Vec3<T> half = T(0.5) * (to - from), middle = T(0.5) * (from + to);
  const auto [s, t] = closest_on_segments(c.half, half, middle - c.centre);
  c.set_normal(manifold, edge_normal);
  c.add(manifold, edge_normal, s, middle + half * t, edge_separation, kClosest);
}

}  // namespace

template <class T>
void collide_sphere_hull(const PairView<T>& pair, const HullView<T>& hull, Manifold<T>& manifold) noexcept {
  const T radius = pair.a.radius;
  const Vec3<T> centre = rotate_inverse(pair.world_from_b, -pair.b_from_a);
  const HighestFace<T> highest = highest_face(hull, centre);
  if (!(highest.height - radius <= pair.margin)) return;
  Vec3<T> on_hull = closest_on_hull(hull, centre), normal = hull.normals[highest.face];
  T distance = norm(centre - on_hull);
  if (distance > kNoDirection<T>)
    normal = (centre - on_hull) * (T(1) / distance);
  else  // the centre is inside: out through the nearest face
    distance = highest.height, on_hull = centre - normal * distance;
  manifold.normal = -rotate(pair.world_from_b, normal);
  const Vec3<T> mid = T(0.5) * (centre - normal * radius + on_hull);
  add_point(pair, manifold, pair.b_from_a + rotate(pair.world_from_b, mid), distance - radius, 0);
}

template <class T>
void collide_capsule_hull(const PairView<T>& pair, const HullView<T>& hull, Manifold<T>& manifold) noexcept {
  const CapsuleHull<T> c{pair, hull, rotate_inverse(pair.world_from_b, -pair.b_from_a),
                         rotate_inverse(pair.world_from_b, capsule_half_axis(pair.a, pair.world_from_a)),
                         pair.a.radius};
  LineRange<T> inside;
  for (std::uint32_t f = 0; f < hull.topology->faces; ++f) {
    const T middle = dot(hull.normals[f], c.centre) - hull.offsets[f], slope = dot(hull.normals[f], c.half);
    if (!(middle - std::abs(slope) - c.radius <= pair.margin)) return;
    cut_range(inside, middle, slope);
  }
  if (!inside.empty()) return collide_inside(c, manifold, inside);
  const Nearest<T> nearest = nearest_outside(c);
  const T distance = std::sqrt(nearest.squared);
  if (!(distance - c.radius <= pair.margin)) return;
  if (distance > kNoDirection<T>) return collide_outside(c, manifold, nearest, distance);
  collide_inside(c, manifold, LineRange<T>{nearest.t, nearest.t});
}

#define TACTUS_INSTANTIATE(T)                                                                          \
  template void collide_sphere_hull<T>(const PairView<T>&, const HullView<T>&, Manifold<T>&) noexcept; \
  template void collide_capsule_hull<T>(const PairView<T>&, const HullView<T>&, Manifold<T>&) noexcept;
TACTUS_INSTANTIATE(double)
TACTUS_INSTANTIATE(float)
#undef TACTUS_INSTANTIATE

}  // namespace tactus::physics
