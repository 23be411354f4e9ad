// A part of a solid, between planes that cut it, and the planes at which it is worth cutting.
//
// A part is held as its share of the solid's surface and the corners inside of the solid at which three cuts meet. Its
// hull is that of all these points: a face of a cut is in the hull of its corners, which are at the rim, on the
// surface, or where cuts meet. So a cut needs no new faces, and the hulls of all parts cover the solid. Units: m.
// Frame: the surface's own. Thread: any normal one. Bound: linear in the triangles, cubic in the cuts. Errors: none.
#pragma once

#include <array>
#include <vector>

#include "tools/import/solid_distance.h"

namespace tactus::scene_import {

struct Plane {
  Vec3d normal;
  double offset{0};
};

// An edge at which the surface is concave, with the normals of its two triangles.
struct Crease {
  Vec3d a, b, normals[2];
};

struct Fragment {
  std::vector<std::array<Vec3d, 3>> triangles;
  std::vector<Crease> creases;
  std::vector<Plane> cuts;           // it is below all of them
  std::vector<Vec3d> inner_corners;  // of three cuts
};

Fragment whole_of(const sim::TriangleSoup& soup);

// The points that make its hull, each one once, in the order of their coordinates.
std::vector<Vec3d> corners_of(const Fragment& fragment);

struct Cut {
  Fragment below, above;
};
// Corners closer to the plane than `rounding_m` lie on it; a triangle in the plane belongs to the side of its solid.
Cut cut(const Fragment& fragment, const Plane& plane, const SolidDistance& solid, double rounding_m);

// Planes through creases, along either triangle and halfway between the two: the crease nearest to `worst` and others,
// evenly from all. Planes along the axes, through `worst` and the quarters of the fragment's box. Each one once.
std::vector<Plane> planes_to_try(const Fragment& fragment, const Vec3d& worst, double rounding_m);

}  // namespace tactus::scene_import
