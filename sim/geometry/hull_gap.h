// How far a body's convex hull is from the surface that its file describes: what is hollow or branches is filled.
// Thread: [setup]. Units: m.
//
// The gap is the Hausdorff distance of the two surfaces: the farthest that a point of the one is from the other. From
// the mesh to the hull it is the depth of a cup; from the hull to the mesh it is what lies between two parts. Found by
// halving triangles, those first that may be farthest, until the rest cannot exceed what was found by more than a
// two-hundredth of the mesh's size. Bound: kMostGapPieces triangles each way; beyond, the gap is a lower bound.
#pragma once

#include "sim/geometry/mesh_builder.h"

namespace tactus::sim {

inline constexpr unsigned kMostGapPieces = 40'000;
inline constexpr double kSmallestGap_m = 1e-4;  // less is not worth a word

struct HullGap {
  double gap_m{0};
  Vec3d at_m;              // where, in the frame of the file's corners
  unsigned open_edges{0};  // of the mesh: there its surface ends
};

// `soup`: welded, in m, one triangle or more with an area. `hull`: of its corners, with its frame in theirs. An error
// says why the triangles make no surface.
Result<HullGap> find_hull_gap(const TriangleSoup& soup, const physics::Hull& hull, const Posed& given_from_hull);

}  // namespace tactus::sim
