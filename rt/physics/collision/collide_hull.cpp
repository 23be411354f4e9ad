// The kernel of two hulls: finds the axis of largest separation among their faces and pairs of edges, then the contact
// points on it.
//
// Every axis gives a lower bound of the distance, so a gap is never reported larger than it is. A face axis is
// preferred to an edge axis, and the axis of the last step to any other, so that the manifold does not alternate.
#include "rt/physics/collision/collide_hull.h"

#include <algorithm>

#include "rt/physics/collision/hull_clip.h"
#include "rt/physics/collision/hull_closest.h"
#include "rt/physics/collision/hull_distance.h"
#include "rt/physics/collision/hull_pair.h"
#include "rt/physics/shapes/segments.h"

namespace tactus::physics {
namespace {

// The reference face chosen from the axes of a pair.
struct ChosenFace {
  bool on_a;
  std::uint32_t face;
  double separation;
};

// Pose of the reference hull in the pair's frame.
struct Placed {
  bool on_a;
  const Quatd& rotation;
  Vec3d centre;

  Placed(const PairView& pair, bool ref_is_a) noexcept
      : on_a(ref_is_a),
        rotation(ref_is_a ? pair.world_from_a : pair.world_from_b),
        centre(ref_is_a ? Vec3d{} : pair.b_from_a) {}
  Vec3d point(const Vec3d& p) const noexcept { return centre + rotate(rotation, p); }
  // `n` points from the reference hull to the other.
  Vec3d normal_to_b(const Vec3d& n) const noexcept { return rotate(rotation, on_a ? n : -n); }
};

AxisCache cache_of(std::uint8_t axis, std::uint32_t a, std::uint32_t b) noexcept {
  return {axis, static_cast<std::uint8_t>(a), static_cast<std::uint8_t>(b)};
}
AxisCache face_of_a(std::uint32_t face) noexcept { return cache_of(kHullFaceA, face, 0); }
AxisCache face_of_b(std::uint32_t face) noexcept { return cache_of(kHullFaceB, 0, face); }

// Separation in front of a face of either hull; minus infinity if the axis is none.
double face_separation(const RelativeHulls& ab, const AxisCache& face) noexcept {
  if (face.axis == kHullFaceA && face.a < ab.ref.topology->faces) return ab.face_separation(face.a);
  if (face.axis != kHullFaceB || face.b >= ab.other.topology->faces) return -std::numeric_limits<double>::infinity();
  const Vec3d n = ab.to_ref(ab.other.normal(face.b));
  return -dot(n, ab.centre) - ab.ref.support_along(-n) - ab.other.offsets[face.b];
}

void report_apart(const PairView& pair, double gap, AxisCache face, Manifold& manifold) noexcept {
  report_gap(pair, gap, manifold);
  manifold.apart = face;
}

// The pair had no contact in the last step: tests the face that separated it then, else asks for the distance. False if
// the hulls are not apart.
bool are_still_apart(const PairView& pair, const RelativeHulls& ab, Manifold& manifold) noexcept {
  // The search of faces may round otherwise.
  if (const double gap = face_separation(ab, pair.apart); gap > pair.margin + kNoDirection) {
    report_apart(pair, gap, pair.apart, manifold);
    return true;
  }
  const HullSeparation gap = gap_of(ab, pair.margin);
  if (!gap.apart) return false;
  const AxisCache a = face_of_a(ab.ref.face_along(gap.along)),
                  b = face_of_b(ab.other.face_along(ab.to_other(-gap.along)));
  const double by_a = face_separation(ab, a), by_b = face_separation(ab, b);
  report_apart(pair, gap.gap, larger(by_a, by_b) > pair.margin ? (by_a < by_b ? b : a) : AxisCache{}, manifold);
  return true;
}

// Tests the edges of the last step's contact before anything else is computed. False if they do not separate the hulls.
bool are_apart_along(const PairView& pair, const RelativeHulls& ab, const AxisCache& edges,
                     Manifold& manifold) noexcept {
  if (edges.a >= ab.ref.topology->edges || edges.b >= ab.other.topology->edges) return false;
  const EdgeAxis axis = edge_axis(ab, edges.a, edges.b);
  if (!axis.found) return false;
  const double gap = ab.separation_along(axis.normal);
  if (!(gap > pair.margin)) return false;
  report_gap(pair, gap, manifold);
  return true;
}

// The incident face, clipped to the reference face.
HullPolygon clipped_face(const RelativeHulls& hulls, std::uint32_t face, const Tangents<double>& along) noexcept {
  const Vec3d n = hulls.ref.normal(face);
  const Vec3d down = hulls.to_other(n);
  const HullTopology& topology = *hulls.other.topology;
  const std::uint32_t incident = hulls.other.face_along(-down);
  HullPolygon polygon;
  for (std::uint32_t k = topology.loop_start[incident]; k < topology.loop_start[incident + 1]; ++k) {
    const std::uint32_t vertex = topology.loop_vertices[k];
    const Vec3d p = hulls.other_vertex(vertex);
    polygon.points[polygon.count++] = {.u = dot(along.t1, p),
                                       .v = dot(along.t2, p),
                                       .w = dot(n, p) - hulls.ref.offsets[face],
                                       .id = vertex,
                                       .line = topology.loop_edges[k],
                                       .kept = false};
  }
  const HullTopology& sides = *hulls.ref.topology;
  const std::uint32_t start = sides.loop_start[face], end = sides.loop_start[face + 1];
  for (std::uint32_t k = start; k < end && polygon.count > 0; ++k) {
    const Vec3d from = hulls.ref.vertex(sides.loop_vertices[k]),
                to = hulls.ref.vertex(sides.loop_vertices[k + 1 == end ? start : k + 1]);
    const double du = dot(along.t1, to - from), dv = dot(along.t2, to - from);
    const double inverse = 1.0 / std::sqrt(du * du + dv * dv);
    const double nu = dv * inverse, nv = -du * inverse;
    clip_to_side(polygon, nu, nv, nu * dot(along.t1, from) + nv * dot(along.t2, from), sides.loop_edges[k]);
  }
  merge_neighbours(polygon);
  return polygon;
}

// Where no part of a face is opposite the other hull: finds the nearest points by alternating projections. A few rounds
// suffice, because the gap along any direction is a lower bound of the distance.
void add_closest_point(const PairView& pair, const RelativeHulls& hulls, const ChosenFace& chosen, double bound,
                       Manifold& manifold) noexcept {
  constexpr int kRounds = 4;
  const Vec3d n_face = hulls.ref.normal(chosen.face);
  Vec3d on_other = hulls.other_vertex(hulls.other.support(hulls.to_other(-n_face))), on_ref;
  for (int round = 0; round < kRounds; ++round) {
    on_ref = closest_on_hull(hulls.ref, on_other);
    const Vec3d seen = hulls.to_other(on_ref - hulls.centre);
    on_other = hulls.centre + hulls.to_ref(closest_on_hull(hulls.other, seen));
  }
  const Vec3d n = direction_or(on_other - on_ref, n_face);
  const double along = hulls.separation_along(n);
  const bool apart = along > 0.0 && along >= bound;
  const Placed placed(pair, chosen.on_a);
  manifold.normal = placed.normal_to_b(apart ? n : n_face);
  add_point(pair, manifold, placed.point(0.5 * (on_ref + on_other)),
            apart         ? along
            : bound > 0.0 ? bound
                          : chosen.separation,
            kClosestType);
}

// Adds up to four of the polygon's points within the margin, midway between the surfaces. `along`: of the polygon.
void add_face_points(const PairView& pair, const RelativeHulls& hulls, const ChosenFace& chosen,
                     const Tangents<double>& along, HullPolygon& polygon, Manifold& manifold) noexcept {
  keep_within(pair.margin, polygon);
  const std::uint32_t type = (chosen.on_a ? kFaceAType : kFaceBType) | chosen.face << 20;
  mark_kept(pair, type, polygon);
  reduce_to_four(polygon);
  const Placed placed(pair, chosen.on_a);
  const Vec3d n = hulls.ref.normal(chosen.face);
  manifold.normal = placed.normal_to_b(n);
  for (std::uint32_t k = 0; k < polygon.count; ++k) {
    const HullClipPoint& p = polygon.points[k];
    const Vec3d mid = n * (hulls.ref.offsets[chosen.face] + 0.5 * p.w) + along.t1 * p.u + along.t2 * p.v;
    add_point(pair, manifold, placed.point(mid), p.w, type | p.id);
  }
}

// `bound`: the largest lower bound of the distance that the axes gave; negative if the hulls overlap.
void add_face_contact(const PairView& pair, const RelativeHulls& hulls, const ChosenFace& chosen, double bound,
                      Manifold& manifold) noexcept {
  const Vec3d n = hulls.ref.normal(chosen.face);
  const Tangents<double> along = tangents_of(n);
  HullPolygon polygon = clipped_face(hulls, chosen.face, along);
  double lowest = 0.0;
  for (std::uint32_t k = 0; k < polygon.count; ++k)
    if (k == 0 || polygon.points[k].w < lowest) lowest = polygon.points[k].w;
  // If the lowest vertex of the other hull is beside the face, the points above the face are higher than the bound. A
  // small difference is subtracted from them; with a large one they are not the closest points.
  const double floor = bound > 0.0 ? bound : 0.0, excess = lowest - floor;
  if (polygon.count == 0 || excess > axis_preference(floor))
    return add_closest_point(pair, hulls, chosen, bound, manifold);
  for (std::uint32_t k = 0; k < polygon.count && excess > 0.0; ++k) polygon.points[k].w -= excess;
  add_face_points(pair, hulls, chosen, along, polygon, manifold);
}

// Adds the points of two edges that cross nearly along the chosen face's normal; `n`: the edges' axis, unit, from A to
// B, in the frame of the reference hull. False if the edges do not meet above the face.
bool add_edges_above_face(const PairView& pair, const RelativeHulls& hulls, const ChosenFace& chosen, const Vec3d& n,
                          double separation, Manifold& manifold) noexcept {
  const Vec3d n_face = hulls.ref.normal(chosen.face);
  const Tangents<double> along = tangents_of(n_face);
  HullPolygon polygon = clipped_face(hulls, chosen.face, along);
  if (!tilt_to_edges(std::abs(dot(n, n_face)), separation, polygon)) return false;
  add_face_points(pair, hulls, chosen, along, polygon, manifold);
  manifold.normal = rotate(chosen.on_a ? pair.world_from_a : pair.world_from_b, n);
  return true;
}

void add_edge_contact(const PairView& pair, const RelativeHulls& ab, const EdgeAxis& axis,
                      Manifold& manifold) noexcept {
  const HullEdge &a = ab.ref.topology->edge[axis.edge], &b = ab.other.topology->edge[axis.other_edge];
  const Vec3d a0 = ab.ref.vertex(a.from), a1 = ab.ref.vertex(a.to), b0 = ab.other_vertex(b.from),
              b1 = ab.other_vertex(b.to);
  const Vec3d half_a = 0.5 * (a1 - a0), half_b = 0.5 * (b1 - b0);
  const Vec3d centre_a = 0.5 * (a0 + a1), centre_b = 0.5 * (b0 + b1);
  const auto [s, t] = closest_on_segments(half_a, half_b, centre_b - centre_a);
  const Placed placed(pair, true);
  manifold.normal = placed.normal_to_b(axis.normal);
  add_point(pair, manifold, placed.point(0.5 * (centre_a + half_a * s + centre_b + half_b * t)), axis.separation,
            kEdgeType | axis.edge << 8 | axis.other_edge);
}

// Where the search of one hull's faces starts: its best face in the last step, or one of the edge's; kMaxHullFaces if
// there was none. `cached_at`: of that hull.
std::uint32_t last_face(const HullTopology& topology, const AxisCache& cached, std::uint32_t cached_at) noexcept {
  if (cached.axis == kHullFaceA || cached.axis == kHullFaceB) return cached_at;
  return cached.axis == kHullEdges && cached_at < topology.edges ? topology.edge[cached_at].left : kMaxHullFaces;
}

// The face of both hulls with the largest separation (A's on a tie), or the last step's if it is about as good.
ChosenFace choose_face(const RelativeHulls& ab, const RelativeHulls& ba, const FaceSearch& best_a,
                       const FaceSearch& best_b, const AxisCache& cached) noexcept {
  const double best = std::max(best_a.separation, best_b.separation);
  const auto about_best = [best](double separation) noexcept {
    return !(best > separation + axis_preference(separation));
  };
  const auto separation_of = [](const RelativeHulls& hulls, const FaceSearch& searched, std::uint32_t face) noexcept {
    return face == searched.face ? searched.separation : hulls.face_separation(face);
  };
  if (cached.axis == kHullFaceA && cached.a < ab.ref.topology->faces)
    if (const double separation = separation_of(ab, best_a, cached.a); about_best(separation))
      return {.on_a = true, .face = cached.a, .separation = separation};
  if (cached.axis == kHullFaceB && cached.b < ba.ref.topology->faces)
    if (const double separation = separation_of(ba, best_b, cached.b); about_best(separation))
      return {.on_a = false, .face = cached.b, .separation = separation};
  if (about_best(best_a.separation)) return {.on_a = true, .face = best_a.face, .separation = best_a.separation};
  return {.on_a = false, .face = best_b.face, .separation = best_b.separation};
}

}  // namespace

void collide_hulls(const PairView& pair, const HullView& a, const HullView& b, Manifold& manifold,
                   AxisCache& cache) noexcept {
  const double margin = pair.margin;
  const AxisCache cached = cache;
  const RelativeHulls ab = relative_hulls(pair, a, b);
  const bool a_last = cached.axis == kHullFaceA, b_last = cached.axis == kHullFaceB;
  if (cached.axis == kHullEdges ? are_apart_along(pair, ab, cached, manifold)
                                : !a_last && !b_last && are_still_apart(pair, ab, manifold))
    return;
  const RelativeHulls ba = ab.reversed();
  // The hull with the last step's face comes first, and that face before the others; of the second hull only a face
  // that is better matters.
  FaceSearch best_a, best_b;
  const auto is_apart = [&](bool of_b, double at_least) noexcept {
    FaceSearch& best = of_b ? best_b : best_a;
    const RelativeHulls& hulls = of_b ? ba : ab;
    find_best_face(hulls, margin, at_least, last_face(*hulls.ref.topology, cached, of_b ? cached.b : cached.a), best);
    if (best.separation <= margin) return false;
    report_apart(pair, best.separation, of_b ? face_of_b(best.face) : face_of_a(best.face), manifold);
    return true;
  };
  if (is_apart(b_last, -std::numeric_limits<double>::infinity())) return;
  if (is_apart(!b_last, (b_last ? best_b : best_a).separation)) return;
  const ChosenFace face = choose_face(ab, ba, best_a, best_b, cached);
  // Edges count only where they beat the face by the preference. Of two hulls that rest on each other the edges of the
  // faces that touch are as deep as these: with the preference nearly all of them are left out at once.
  const double best = std::max(best_a.separation, best_b.separation);
  const double at_least =
      std::max(best, face.separation + edge_preference(face.separation, false, cached.axis == kHullEdges));
  const EdgeAxis edges = best_edges(ab, margin, at_least, best_a, best_b);
  if (edges.found && edges.separation > margin) return report_gap(pair, edges.separation, manifold);
  const Vec3d face_normal = face.on_a ? ab.ref.normal(face.face) : ab.to_ref(ba.ref.normal(face.face));
  const bool along_face = edges.found && is_along_face(edges.normal, face_normal);
  if (edges.found &&
      edges.separation > face.separation + edge_preference(face.separation, along_face, cached.axis == kHullEdges)) {
    cache = cache_of(kHullEdges, edges.edge, edges.other_edge);
    const Vec3d n = face.on_a ? edges.normal : ba.to_ref(edges.normal);
    if (along_face && add_edges_above_face(pair, face.on_a ? ab : ba, face, n, edges.separation, manifold)) return;
    return add_edge_contact(pair, ab, edges, manifold);
  }
  cache = face.on_a ? cache_of(kHullFaceA, face.face, best_b.face) : cache_of(kHullFaceB, best_a.face, face.face);
  add_face_contact(pair, face.on_a ? ab : ba, face, edges.found ? edges.separation : best, manifold);
}

// Adds the vertices of one face: of the faces at the lowest vertex, the one that points down most. Feature: the vertex.
void collide_plane_hull(const PairView& pair, const HullView& hull, Manifold& manifold) noexcept {
  const Vec3d up = axes_of(pair.world_from_a).z, up_in_hull = rotate_inverse(pair.world_from_b, up);
  const std::uint32_t lowest = hull.support(-up_in_hull);
  const auto height = [&](std::uint32_t i) noexcept {
    return dot(up, pair.b_from_a) + dot(up_in_hull, hull.vertex(i));
  };
  if (!(height(lowest) <= pair.margin) || !std::isfinite(height(lowest))) return;
  std::uint32_t face = kMaxHullFaces;
  double least = 2.0;
  for (std::uint32_t f = 0; f < hull.topology->faces; ++f) {
    const double cosine = dot(up_in_hull, hull.normal(f));
    if (!(cosine < least)) continue;
    const auto loop = hull.topology->loop(f);
    if (std::find(loop.begin(), loop.end(), lowest) != loop.end()) {
      face = f;
      least = cosine;
    }
  }
  if (face == kMaxHullFaces) return;
  const Tangents<double> along = tangents_of(hull.normal(face));
  HullPolygon polygon;
  for (const std::uint8_t i : hull.topology->loop(face)) {
    const Vec3d p = hull.vertex(i);
    if (const double w = height(i); w <= pair.margin)
      polygon.points[polygon.count++] = {
          .u = dot(along.t1, p), .v = dot(along.t2, p), .w = w, .id = i, .line = 0, .kept = false};
  }
  mark_kept(pair, 0, polygon);
  reduce_to_four(polygon);
  manifold.normal = up;
  for (std::uint32_t k = 0; k < polygon.count; ++k) {
    const HullClipPoint& p = polygon.points[k];
    const Vec3d vertex = pair.b_from_a + rotate(pair.world_from_b, hull.vertex(p.id));
    add_point(pair, manifold, vertex - up * (0.5 * p.w), p.w, p.id);
  }
}

}  // namespace tactus::physics
