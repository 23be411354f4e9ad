// Inside narrow phase: two hulls as seen from one of them, and the axis that separates them best. Thread: [any]; pure.
//
// Frame: that of the hull called `ref`. Units: m.
// Bound: every face looks at every vertex of the other hull at most once, every edge at every edge; faces and edges
// that cannot beat the best axis so far are left out beforehand, which leaves few of them where hulls touch.
#pragma once

#include "rt/physics/collision/collide.h"
#include "rt/physics/shapes/hull_view.h"

namespace tactus::physics {

template <class T>
struct RelativeHulls {
  HullView<T> ref, other;
  Vec3<T> column[3];  // axes of the other in the frame of ref
  Vec3<T> centre;     // m, of the other

  Vec3<T> to_ref(const Vec3<T>& v) const noexcept { return column[0] * v.x + column[1] * v.y + column[2] * v.z; }
  Vec3<T> to_other(const Vec3<T>& v) const noexcept {
    return {dot(column[0], v), dot(column[1], v), dot(column[2], v)};
  }
  Vec3<T> other_vertex(std::uint32_t i) const noexcept { return centre + to_ref(other.vertex(i)); }

  // The same pair from the other side.
  RelativeHulls reversed() const noexcept {
    return {other,
            ref,
            {{column[0].x, column[1].x, column[2].x},
             {column[0].y, column[1].y, column[2].y},
             {column[0].z, column[1].z, column[2].z}},
            -to_other(centre)};
  }

  T face_separation(std::uint32_t face) const noexcept {
    const Vec3<T>& n = ref.normals[face];
    return dot(n, centre) - other.reach_along(to_other(-n)) - ref.offsets[face];
  }
  // Gap between the shadows on the unit vector n, which points from ref to the other.
  T separation_along(const Vec3<T>& n) const noexcept {
    return dot(n, centre) - other.reach_along(to_other(-n)) - ref.reach_along(n);
  }
};

template <class T>
RelativeHulls<T> relative_hulls(const PairView<T>& pair, const HullView<T>& a, const HullView<T>& b) noexcept {
  const Axes<T> axes = axes_of(conjugate(pair.world_from_a) * pair.world_from_b);
  return {a, b, {axes.x, axes.y, axes.z}, rotate_inverse(pair.world_from_a, pair.b_from_a)};
}

template <class T>
struct FaceAxis {
  std::uint32_t face{0};
  T separation{};
};
// The face of ref that separates best (the lower one on a tie; `first` before all), or the first found whose separation
// is above the margin. `first`: a face to begin with, or any number beyond.
template <class T>
FaceAxis<T> best_face(const RelativeHulls<T>& hulls, T margin, std::uint32_t first) noexcept;

template <class T>
struct EdgeAxis {
  bool found{false};
  std::uint32_t edge{0}, other_edge{0};
  Vec3<T> normal;  // unit, from ref to the other
  T separation{};
};
// The pair of edges that separates best, if it beats `at_least`, or the first found whose separation is above the
// margin. Edges within 0.3 degrees of parallel are left out: faces say the same.
template <class T>
EdgeAxis<T> best_edges(const RelativeHulls<T>& hulls, T margin, T at_least, std::uint32_t best_face_of_ref,
                       std::uint32_t best_face_of_other) noexcept;

// The axis of one pair of edges, where they make one.
template <class T>
EdgeAxis<T> edge_axis(const RelativeHulls<T>& hulls, std::uint32_t edge, std::uint32_t other_edge) noexcept;

}  // namespace tactus::physics
