// The simplex of the algorithm of Gilbert, Johnson and Keerthi (1988). Inside narrow phase. Thread: [any]; pure,
// bounded. Units: m. Source of the closest points: Ericson 2005, section 5.1.
#pragma once

#include "rt/base/spatial.h"

namespace tactus::physics {

// One to four points of the difference of two convex shapes (other minus ref).
struct Simplex {
  int count{0};
  Vec3d p[4];

  // Reduce the simplex to one corner, to one edge; return the corner, the point a + t (b - a).
  Vec3d keep(const Vec3d& a) noexcept {
    p[0] = a;
    count = 1;
    return a;
  }
  Vec3d keep(const Vec3d& a, const Vec3d& b, double t) noexcept {
    p[0] = a;
    p[1] = b;
    count = 2;
    return a + (b - a) * t;
  }
};

// Returns the point of the simplex nearest to the origin, and reduces the simplex to the points that span it.
Vec3d nearest_of(Simplex& simplex) noexcept;

}  // namespace tactus::physics
