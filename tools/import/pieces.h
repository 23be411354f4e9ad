// Concave meshes: how far their convex hull is from them, and their decomposition into convex pieces.
//
// The piece whose hull is furthest from the solid is cut by a plane, again and again: the plane of several (fragment.h)
// that leaves the least volume in the two hulls (as Mamou 2016, "Volumetric hierarchical approximate convex
// decomposition", does with planes along the axes). Then pieces that touch are joined where the hull of both is near
// enough. The hulls cover the solid, so only what they fill beyond it is an error. Units: m. Frame: the mesh's own.
// Thread: any normal one. Bound: kMaxPieceTriangles of the mesh, twice as many cuts as pieces are wanted. Errors: one
// line with what was found and what is accepted.
#pragma once

#include "rt/base/result.h"
#include "tools/import/hull_shapes.h"

namespace tactus::scene_import {

inline constexpr std::size_t kMaxPieceTriangles = 20'000;

// Edges at which the welded surface does not close: not exactly two triangles that agree on what is outside.
std::size_t open_edges(const sim::TriangleSoup& soup);

// The largest gap between the surface and its points' hull, to 1/200 of its size; 0 where it is smaller than 0.1 mm.
Result<double> hull_gap(const sim::TriangleSoup& soup, const HullPoints& hull);

// At least one convex piece, at most `most`. `deviation_m`: no point of a piece is further from the solid, and no point
// of the solid further from the pieces. As few pieces as are found for the deviation that is wanted; where `most` do
// not suffice, the deviation is larger. An error where the mesh is too large or too thin.
struct Pieces {
  std::vector<HullPoints> hulls;
  double deviation_m{0};
};
Result<Pieces> decompose(const sim::TriangleSoup& soup, unsigned most, double deviation_m);

}  // namespace tactus::scene_import
