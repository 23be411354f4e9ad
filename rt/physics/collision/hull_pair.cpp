#include "rt/physics/collision/hull_pair.h"

namespace tactus::physics {
namespace {

struct EdgeList {
  std::uint32_t count{0};
  std::array<std::uint8_t, kMaxHullEdges> edge;
};

// Lists the edges of ref that may separate the hulls by more than `at_least`.
//
// An axis between the normals n0, n1 of an edge's faces is a n0 + b n1 with a + b between 1 and edge_reach. A point of
// the other hull at distances d0, d1 from the two planes bounds the separation along such an axis: by max(d0, d1) if
// that is not positive, else by edge_reach times it; for a sphere about the point its radius is subtracted. Two points
// are tested: the centre with the inscribed sphere, and the vertex that is deepest behind the best face.
void list_edges(const RelativeHulls& hulls, double at_least, const FaceSearch& search, EdgeList& list) noexcept {
  const HullTopology& topology = *hulls.ref.topology;
  const Vec3d deepest = hulls.other_vertex(hulls.other.support(hulls.to_other(-hulls.ref.normal(search.face))));
  // The planes of merged faces are outside their vertices by up to the flatness.
  const double slack = hulls.ref.flatness;
  const auto bound = [slack](double d0, double d1, double reach) noexcept {
    const double d = larger(d0, d1) + slack;
    return d > 0.0 ? d * reach : d;
  };
  // An edge passes the first test only if the centre is high enough above one of its faces, with the largest reach of
  // all edges. Few faces are, and only their edges are visited, each from its left face if that is high enough.
  const double by_centre = at_least + hulls.other.inner_radius;
  const double least = (by_centre > 0.0 ? by_centre / hulls.ref.largest_reach : by_centre) - slack;
  for (std::uint32_t f = 0; f < topology.faces; ++f) {
    if (search.centre.of[f] < least) continue;
    for (std::uint32_t k = topology.loop_start[f]; k < topology.loop_start[f + 1]; ++k) {
      const std::uint8_t e = topology.loop_edges[k];
      const HullEdge& edge = topology.edge[e];
      if (edge.left != f && !(search.centre.of[edge.left] < least)) continue;
      const double reach = hulls.ref.edge_reach[e];
      if (bound(search.centre.of[edge.left], search.centre.of[edge.right], reach) < by_centre) continue;
      if (bound(hulls.ref.height(edge.left, deepest), hulls.ref.height(edge.right, deepest), reach) < at_least)
        continue;
      list.edge[list.count++] = e;
    }
  }
}

// An edge of the other hull in the frame of ref, with the normals of its faces. An array of plain numbers, because
// clearing a list of them before it is filled cost more than all the rest.
struct OtherEdge {
  double number[9];

  void set(const Vec3d& along, const Vec3d& left, const Vec3d& right) noexcept {
    const Vec3d v[3] = {along, left, right};
    for (int i = 0; i < 9; ++i) number[i] = v[i / 3][i % 3];
  }
  Vec3d along() const noexcept { return {number[0], number[1], number[2]}; }
  Vec3d left() const noexcept { return {number[3], number[4], number[5]}; }
  Vec3d right() const noexcept { return {number[6], number[7], number[8]}; }
};

}  // namespace

void find_best_face(const RelativeHulls& hulls, double margin, std::uint32_t first, FaceSearch& search) noexcept {
  // The inscribed sphere of the other hull bounds each separation from above; the face with the largest bound is tested
  // first.
  const std::uint32_t faces = hulls.ref.topology->faces;
  const double inner_radius = hulls.other.inner_radius;
  hulls.ref.heights(hulls.centre, search.centre);
  std::uint32_t start = first;
  if (!(first < faces)) {
    start = 0;
    for (std::uint32_t f = 1; f < faces; ++f)
      if (search.centre.of[f] > search.centre.of[start]) start = f;
  }
  search.face = start;
  search.separation = hulls.face_separation(start);
  for (std::uint32_t f = 0; f < faces; ++f) {
    if (!(search.separation <= margin)) return;  // also if a pose is not finite
    if (f == start || search.centre.of[f] - inner_radius < search.separation) continue;
    const double separation = hulls.face_separation(f);
    if (separation > search.separation) {
      search.face = f;
      search.separation = separation;
    }
  }
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
  return {true, e, other_e, n, dot(n, hulls.centre + hulls.to_ref(other_from) - from)};
}

// Two edges make a face of the Minkowski difference if and only if their arcs on the Gauss sphere cross (Gregorius
// 2013): the face normals of each edge are on different sides of the plane normal to the other edge, and both arcs are
// on the same hemisphere.
EdgeAxis best_edges(const RelativeHulls& hulls, double margin, double at_least, const FaceSearch& of_ref,
                    const FaceSearch& of_other) noexcept {
  EdgeAxis best;
  best.separation = at_least;
  EdgeList mine, others;
  list_edges(hulls, at_least, of_ref, mine);
  if (mine.count == 0) return best;
  list_edges(hulls.reversed(), at_least, of_other, others);
  std::array<OtherEdge, kMaxHullEdges> other;
  for (std::uint32_t j = 0; j < others.count; ++j) {
    const HullEdge& edge = hulls.other.topology->edge[others.edge[j]];
    other[j].set(hulls.to_ref(hulls.other.vertex(edge.to) - hulls.other.vertex(edge.from)),
                 hulls.to_ref(hulls.other.normal(edge.left)), hulls.to_ref(hulls.other.normal(edge.right)));
  }
  for (std::uint32_t i = 0; i < mine.count; ++i) {
    const HullEdge& edge = hulls.ref.topology->edge[mine.edge[i]];
    const Vec3d along = hulls.ref.vertex(edge.to) - hulls.ref.vertex(edge.from);
    const Vec3d left = hulls.ref.normal(edge.left), right = hulls.ref.normal(edge.right);
    for (std::uint32_t j = 0; j < others.count; ++j) {
      const double other_left = dot(other[j].left(), along), other_right = dot(other[j].right(), along);
      if (!(other_left * other_right < 0.0)) continue;
      const double my_left = dot(left, other[j].along()), my_right = dot(right, other[j].along());
      if (!(my_left * my_right < 0.0 && other_left * my_right < 0.0)) continue;
      const EdgeAxis axis = edge_axis(hulls, mine.edge[i], others.edge[j]);
      if (!axis.found || !(axis.separation > best.separation)) continue;
      best = axis;
      if (best.separation > margin) return best;
    }
  }
  return best;
}

}  // namespace tactus::physics
