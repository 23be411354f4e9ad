// Separating axes of a box and a triangle, for triangles at the rim of a mesh's patch: what find_best_face and
// best_edges (hull_pair.h) find for the two as hulls, without their lists.
//
// All nine axes of an edge of the triangle and an edge of the box are tested, three at a time, each in the direction in
// which the triangle's edge is its farthest part: so every one is a face of the Minkowski difference.
// Frame: the box's axes and centre. Units: m. Thread: [any]; pure. Bound: constant.
// Source: separating axes, Gottschalk 1996.
#pragma once

#include <array>
#include <cstdint>

#include "rt/base/wide.h"
#include "rt/physics/collision/hull_pair.h"

namespace tactus::physics {

struct BoxTriangle {
  Vec3d half;                   // extents of the box
  std::array<Vec3d, 3> corner;  // of the triangle
  Vec3d middle;                 // mean of the corners
};

struct BoxFace {
  std::uint32_t face{0};  // as in kBoxTopology
  double separation{};
};
// The face of the box with the largest separation; on a tie the first of those nearest to the triangle's middle.
BoxFace best_box_face(const BoxTriangle& pair) noexcept;

// The pair of edges with the largest separation, if it exceeds `at_least`; otherwise `separation` is `at_least`.
// `edge`: of the triangle, from its corner to the next; `other_edge`: of kBoxTopology. The normal points from the
// triangle to the box. Edges within 0.3 degrees of parallel are skipped.
EdgeAxis best_box_edges(const BoxTriangle& pair, double at_least) noexcept;

}  // namespace tactus::physics
