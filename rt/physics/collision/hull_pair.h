// The axis of largest separation of two hulls. Inside narrow phase. Thread: [any]; pure.
//
// Frame: that of the hull called `ref`. Units: m.
// Bound: each face is tested against each vertex of the other hull at most once, and each edge against each edge; faces
// and edges that cannot beat the best axis so far are excluded first, which leaves few of them for hulls in contact.
#pragma once

#include "rt/physics/collision/collide.h"
#include "rt/physics/shapes/hull_view.h"

namespace tactus::physics {

struct RelativeHulls {
  HullView ref, other;
  Vec3d column[3];  // axes of the other in the frame of ref
  Vec3d centre;     // m, of the other

  Vec3d to_ref(const Vec3d& v) const noexcept { return column[0] * v.x + column[1] * v.y + column[2] * v.z; }
  Vec3d to_other(const Vec3d& v) const noexcept { return {dot(column[0], v), dot(column[1], v), dot(column[2], v)}; }
  Vec3d other_vertex(std::uint32_t i) const noexcept { return centre + to_ref(other.vertex(i)); }

  // The same pair with the other hull as `ref`.
  RelativeHulls reversed() const noexcept {
    return {.ref = other,
            .other = ref,
            .column = {{column[0].x, column[1].x, column[2].x},
                       {column[0].y, column[1].y, column[2].y},
                       {column[0].z, column[1].z, column[2].z}},
            .centre = -to_other(centre)};
  }

  double face_separation(std::uint32_t face) const noexcept {
    const Vec3d n = ref.normal(face);
    return dot(n, centre) - other.support_along(to_other(-n)) - ref.offsets[face];
  }
  // Gap between the projections onto the unit vector n, which points from ref to the other.
  double separation_along(const Vec3d& n) const noexcept {
    return dot(n, centre) - other.support_along(to_other(-n)) - ref.support_along(n);
  }
};

inline RelativeHulls relative_hulls(const PairView& pair, const HullView& a, const HullView& b) noexcept {
  const Axes axes = axes_of(conjugate(pair.world_from_a) * pair.world_from_b);
  return {.ref = a,
          .other = b,
          .column = {axes.x, axes.y, axes.z},
          .centre = rotate_inverse(pair.world_from_a, pair.b_from_a)};
}

// The search of faces, for one of the hulls; the search of edges goes on with it.
struct FaceSearch {
  std::uint32_t face{0};  // with the largest separation
  double separation{};
  FaceHeights centre;   // of the other hull's centre above the faces
  FaceHeights deepest;  // of the other hull's vertex that is deepest behind the face; only if that is within the margin
};
// Fills all but `centre` for a face that is given.
void hold_face(const RelativeHulls& hulls, std::uint32_t face, double margin, FaceSearch& search) noexcept;
// Finds the face of ref with the largest separation (`first` on a tie, or the face where the search starts), or the
// first one found whose separation exceeds the margin. `first`: the face to test first, or any number >= faces.
// `at_least`: faces below it do not matter; where all are, `search` is one of them.
void find_best_face(const RelativeHulls& hulls, double margin, double at_least, std::uint32_t first,
                    FaceSearch& search) noexcept;

struct EdgeAxis {
  bool found{false};
  std::uint32_t edge{0}, other_edge{0};
  Vec3d normal;  // unit, from ref to the other
  double separation{};
};
// The pair of edges with the largest separation, if it exceeds `at_least`, or the first one found whose separation
// exceeds the margin. Edges within 0.3 degrees of parallel are skipped: the face axes cover them.
EdgeAxis best_edges(const RelativeHulls& hulls, double margin, double at_least, const FaceSearch& of_ref,
                    const FaceSearch& of_other) noexcept;

// The axis of one pair of edges; `found` is false if they are parallel.
EdgeAxis edge_axis(const RelativeHulls& hulls, std::uint32_t edge, std::uint32_t other_edge) noexcept;

}  // namespace tactus::physics
