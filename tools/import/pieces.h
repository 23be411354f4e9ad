// Concave meshes: how far their convex hull is from them, and their decomposition into convex pieces by Bullet's HACD.
//
// Units: m. Frame: the mesh's own. Thread: any normal one. Bound: kMaxPieceTriangles of the mesh. Errors: one line with
// what was found and what is accepted.
#pragma once

#include "rt/base/result.h"
#include "tools/import/hull_shapes.h"

namespace tactus::scene_import {

inline constexpr std::size_t kMaxPieceTriangles = 20'000;
inline constexpr int kSurfacePoints = 10'000;  // of each surface, where two are compared

// Edges at which the welded surface does not close: not exactly two triangles that agree on what is outside.
std::size_t open_edges(const sim::TriangleSoup& soup);

// The largest gap between the surface and its points' hull, to 1/200 of its size; 0 where it is smaller than 0.1 mm.
Result<double> hull_gap(const sim::TriangleSoup& soup, const HullPoints& hull);

// At most `most` convex pieces. An error where the program has no HACD, or where their surface is further from the
// mesh's than `deviation_m`.
struct Pieces {
  std::vector<HullPoints> hulls;
  double deviation_m{0};
};
Result<Pieces> decompose(const sim::TriangleSoup& soup, unsigned most, double deviation_m);

}  // namespace tactus::scene_import
