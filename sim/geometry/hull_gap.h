// Measures the distance between a body's convex hull and the surface in its file: the hull fills concave regions.
// Thread: [setup]. Units: m.
//
// The gap is the Hausdorff distance of the two surfaces: the largest distance of a point on one to the other. From mesh
// to hull it is, for example, the depth of a cup; from hull to mesh, the gap between two parts. Found by bisection of
// triangles, largest upper bound first, until no remaining triangle can exceed the result by more than 1/200 of the
// mesh's diagonal. Bound: kMaxGapPieces triangles each way; beyond, the gap is a lower bound.
#pragma once

#include "sim/geometry/mesh_builder.h"

namespace tactus::sim {

inline constexpr unsigned kMaxGapPieces = 40'000;
inline constexpr double kSmallestGap_m = 1e-4;  // smaller gaps are not reported

struct HullGap {
  double gap_m{0};
  Vec3d at_m;              // the point with that distance, in the frame of the file's corners
  unsigned open_edges{0};  // of the mesh: edges where its surface is open
};

// `soup`: welded, in m, with at least one triangle of non-zero area. `hull`: of its corners; `given_from_hull`: the
// pose of the hull's frame in theirs. An error says why the triangles make no surface.
Result<HullGap> find_hull_gap(const TriangleSoup& soup, const physics::Hull& hull, const Posed& given_from_hull);

}  // namespace tactus::sim
