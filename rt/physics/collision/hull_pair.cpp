#include "rt/physics/collision/hull_pair.h"

namespace tactus::physics {
namespace {

// Calls f for each face whose height is not below `least`, in ascending order.
template <class F>
TACTUS_INLINE void for_each_face_above(const FaceHeights& heights, double least, std::uint32_t faces, F f) noexcept {
  using V = HullView::V;
  const V lowest(least);
  for (std::uint32_t block = 0; block < faces; block += kLanes<V>) {
    V height;
    load(height, heights.of + block);
    if (!any(lowest <= height)) continue;
    const std::uint32_t end = block + kLanes<V> < faces ? block + kLanes<V> : faces;
    for (std::uint32_t i = block; i < end; ++i)
      if (!(heights.of[i] < least)) f(i);
  }
}

struct EdgeList {
  std::uint32_t count{0};
  std::array<std::uint8_t, kMaxHullEdges> edge;
};

// Lists the edges of ref that may separate the hulls by more than `at_least`.
//
// An axis between the normals n0, n1 of an edge's faces is a n0 + b n1 with a + b between 1 and edge_secant. A point of
// the other hull at distances d0, d1 from the two planes bounds the separation along such an axis: by max(d0, d1) if
// that is not positive, else by edge_secant times it; for a sphere about the point its radius is subtracted. Two points
// are tested: the centre with the inscribed sphere, and the vertex that is deepest behind the best face.
void list_edges(const RelativeHulls& hulls, double at_least, const FaceSearch& search, EdgeList& list) noexcept {
  const HullTopology& topology = *hulls.ref.topology;
  // The planes of merged faces are outside their vertices by up to the flatness.
  const double slack = hulls.ref.flatness;
  const auto bound = [slack](double d0, double d1, double secant) noexcept {
    const double d = larger(d0, d1) + slack;
    return d > 0.0 ? d * secant : d;
  };
  // An edge passes a test only if the point is high enough above one of its faces, with the largest secant of all
  // edges. Fewest faces are below the deepest vertex; only their edges are visited, each from its left face if that is
  // one of them.
  const double by_centre = at_least + hulls.other.inner_radius;
  const double least = (at_least > 0.0 ? at_least / hulls.ref.largest_secant : at_least) - slack;
  for_each_face_above(search.deepest, least, topology.faces, [&](std::uint32_t f) noexcept {
    for (std::uint32_t k = topology.loop_start[f]; k < topology.loop_start[f + 1]; ++k) {
      const std::uint8_t e = topology.loop_edges[k];
      const HullEdge& edge = topology.edge[e];
      if (edge.left != f && !(search.deepest.of[edge.left] < least)) continue;
      const double secant = hulls.ref.edge_secant[e];
      if (bound(search.centre.of[edge.left], search.centre.of[edge.right], secant) < by_centre) continue;
      if (bound(search.deepest.of[edge.left], search.deepest.of[edge.right], secant) < at_least) continue;
      list.edge[list.count++] = e;
    }
  });
}

// Edges of the other hull in the frame of ref, with the normals of their faces: a number in each row, so that several
// edges are tested at once. Plain numbers, because clearing a list of vectors before it is filled cost more than all
// the rest.
struct OtherEdges {
  using V = HullView::V;
  static constexpr std::uint32_t kPadded = (kMaxHullEdges + kLanes<V> - 1) / kLanes<V> * kLanes<V>;
  enum Row { kAlong, kLeft, kRight };
  alignas(32) double number[9][kPadded];

  void set(std::uint32_t i, Row row, const Vec3d& v) noexcept {
    for (int k = 0; k < 3; ++k) number[3 * row + k][i] = v[k];
  }
  TACTUS_INLINE V dots(Row row, std::uint32_t i, const Vec3d& v) const noexcept {
    V x, y, z;
    load(x, number[3 * row] + i);
    load(y, number[3 * row + 1] + i);
    load(z, number[3 * row + 2] + i);
    return x * V(v.x) + y * V(v.y) + z * V(v.z);
  }
};

}  // namespace

void hold_face(const RelativeHulls& hulls, std::uint32_t face, double margin, FaceSearch& search) noexcept {
  const Vec3d n = hulls.ref.normal(face), down = hulls.to_other(-n);
  const std::uint32_t deepest = hulls.other.support(down);
  search.face = face;
  search.separation = dot(n, hulls.centre) - dot(down, hulls.other.vertex(deepest)) - hulls.ref.offsets[face];
  if (search.separation <= margin) hulls.ref.heights(hulls.other_vertex(deepest), search.deepest);
}

void find_best_face(const RelativeHulls& hulls, double margin, double at_least, std::uint32_t first,
                    FaceSearch& search) noexcept {
  // Two points bound each separation from above: the centre of the other hull, with its inscribed sphere, and the
  // vertex that is deepest behind the first face. The face with the largest bound by the first is tested first.
  const std::uint32_t faces = hulls.ref.topology->faces;
  const double inner_radius = hulls.other.inner_radius;
  hulls.ref.heights(hulls.centre, search.centre);
  std::uint32_t start = first;
  if (!(first < faces)) {
    start = 0;
    for (std::uint32_t f = 1; f < faces; ++f)
      if (search.centre.of[f] > search.centre.of[start]) start = f;
  }
  hold_face(hulls, start, margin, search);
  constexpr double rounding = kNoDirection;  // m: of the second bound
  using V = HullView::V;
  std::uint32_t best = start;
  for (std::uint32_t block = 0; block < faces; block += kLanes<V>) {
    if (!(search.separation <= margin)) return;  // also if a pose is not finite
    V centre, deepest;
    load(centre, search.centre.of + block);
    load(deepest, search.deepest.of + block);
    const V least(larger(search.separation, at_least));
    if (!any(both(least <= centre - V(inner_radius), least - V(rounding) <= deepest))) continue;
    const std::uint32_t end = block + kLanes<V> < faces ? block + kLanes<V> : faces;
    for (std::uint32_t f = block; f < end && search.separation <= margin; ++f) {
      const double floor = larger(search.separation, at_least);
      if (f == start || search.centre.of[f] - inner_radius < floor) continue;
      if (search.deepest.of[f] < floor - rounding) continue;
      const double separation = hulls.face_separation(f);
      if (!(separation > search.separation)) continue;
      best = f;
      search.separation = separation;
    }
  }
  if (best != start) hold_face(hulls, best, margin, search);
}

EdgeAxis edge_axis(const RelativeHulls& hulls, std::uint32_t e, std::uint32_t other_e) noexcept {
  const HullEdge &edge = hulls.ref.topology->edge[e], &other = hulls.other.topology->edge[other_e];
  const Vec3d from = hulls.ref.vertex(edge.from), other_from = hulls.other.vertex(other.from);
  const Vec3d along = hulls.ref.vertex(edge.to) - from,
              other_along = hulls.to_ref(hulls.other.vertex(other.to) - other_from);
  const Vec3d w = cross(along, other_along);
  const double length_squared = norm_squared(w);
  if (!(length_squared > kParallelSineSquared * norm_squared(along) * norm_squared(other_along))) return {};
  // The origin is inside ref, so the outward direction is the one towards the edge's vertices.
  const Vec3d n = w * ((dot(w, from) < 0.0 ? -1.0 : 1.0) / std::sqrt(length_squared));
  return {.found = true,
          .edge = e,
          .other_edge = other_e,
          .normal = n,
          .separation = dot(n, hulls.centre + hulls.to_ref(other_from) - from)};
}

// Two edges make a face of the Minkowski difference if and only if their arcs on the Gauss sphere cross (Gregorius
// 2013): the face normals of each edge are on different sides of the plane normal to the other edge, and both arcs are
// on the same hemisphere.
EdgeAxis best_edges(const RelativeHulls& hulls, double margin, double at_least, const FaceSearch& of_ref,
                    const FaceSearch& of_other) noexcept {
  EdgeAxis best;
  best.separation = at_least;
  // The hull with the better face comes first: mostly none of its edges is left.
  EdgeList mine, others;
  const auto lists_any = [&](bool of_ref_hull) noexcept {
    if (of_ref_hull)
      list_edges(hulls, at_least, of_ref, mine);
    else
      list_edges(hulls.reversed(), at_least, of_other, others);
    return (of_ref_hull ? mine : others).count > 0;
  };
  const bool ref_first = !(of_ref.separation < of_other.separation);
  if (!lists_any(ref_first) || !lists_any(!ref_first)) return best;
  OtherEdges other;
  constexpr std::uint32_t lanes = kLanes<OtherEdges::V>;
  for (std::uint32_t j = 0; j < others.count; ++j) {
    const HullEdge& edge = hulls.other.topology->edge[others.edge[j]];
    other.set(j, OtherEdges::kAlong, hulls.to_ref(hulls.other.vertex(edge.to) - hulls.other.vertex(edge.from)));
    other.set(j, OtherEdges::kLeft, hulls.to_ref(hulls.other.normal(edge.left)));
    other.set(j, OtherEdges::kRight, hulls.to_ref(hulls.other.normal(edge.right)));
  }
  for (std::uint32_t j = others.count; j % lanes != 0; ++j)
    for (auto& row : other.number) row[j] = 0.0;
  const OtherEdges::V zero(0.0);
  for (std::uint32_t i = 0; i < mine.count; ++i) {
    const HullEdge& edge = hulls.ref.topology->edge[mine.edge[i]];
    const Vec3d along = hulls.ref.vertex(edge.to) - hulls.ref.vertex(edge.from);
    const Vec3d left = hulls.ref.normal(edge.left), right = hulls.ref.normal(edge.right);
    for (std::uint32_t j = 0; j < others.count; j += lanes) {
      const auto other_left = other.dots(OtherEdges::kLeft, j, along),
                 other_right = other.dots(OtherEdges::kRight, j, along);
      const auto my_left = other.dots(OtherEdges::kAlong, j, left), my_right = other.dots(OtherEdges::kAlong, j, right);
      const auto cross =
          both(both(other_left * other_right < zero, my_left * my_right < zero), other_left * my_right < zero);
      if (!any(cross)) continue;
      for (std::uint32_t lane = 0; lane < lanes; ++lane) {
        if (cross[lane] == 0) continue;
        const EdgeAxis axis = edge_axis(hulls, mine.edge[i], others.edge[j + lane]);
        if (!axis.found || !(axis.separation > best.separation)) continue;
        best = axis;
        if (best.separation > margin) return best;
      }
    }
  }
  return best;
}

}  // namespace tactus::physics
