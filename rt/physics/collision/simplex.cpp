#include "rt/physics/collision/simplex.h"

namespace tactus::physics {
namespace {

// Each function returns the point of the simplex nearest to the origin, and reduces the simplex to the points that span
// it.
Vec3d nearest_of_segment(Simplex& simplex) noexcept {
  const Vec3d a = simplex.p[0], b = simplex.p[1], ab = b - a;
  const double along = -dot(a, ab), length_squared = norm_squared(ab);
  if (along <= 0.0) return simplex.keep(a);
  if (along >= length_squared) return simplex.keep(b);
  return a + ab * (along / length_squared);
}

Vec3d nearest_of_triangle(Simplex& simplex) noexcept {
  const Vec3d a = simplex.p[0], b = simplex.p[1], c = simplex.p[2], ab = b - a, ac = c - a;
  const double d1 = -dot(ab, a), d2 = -dot(ac, a);
  if (d1 <= 0.0 && d2 <= 0.0) return simplex.keep(a);
  const double d3 = -dot(ab, b), d4 = -dot(ac, b);
  if (d3 >= 0.0 && d4 <= d3) return simplex.keep(b);
  const double d5 = -dot(ab, c), d6 = -dot(ac, c);
  if (d6 >= 0.0 && d5 <= d6) return simplex.keep(c);
  const double vc = d1 * d4 - d3 * d2, vb = d5 * d2 - d1 * d6, va = d3 * d6 - d5 * d4;
  if (vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0) return simplex.keep(a, b, d1 / (d1 - d3));
  if (vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0) return simplex.keep(a, c, d2 / (d2 - d6));
  if (va <= 0.0 && d4 >= d3 && d5 >= d6) return simplex.keep(b, c, (d4 - d3) / ((d4 - d3) + (d5 - d6)));
  const double whole = 1.0 / (va + vb + vc);
  return a + ab * (vb * whole) + ac * (vc * whole);
}

// The nearest of the faces that have the origin on their outer side; the origin itself if there is none.
Vec3d nearest_of_tetrahedron(Simplex& simplex) noexcept {
  constexpr int faces[4][4] = {{0, 1, 2, 3}, {0, 2, 3, 1}, {0, 3, 1, 2}, {1, 3, 2, 0}};  // the last one is opposite
  const Simplex whole = simplex;
  Vec3d best;
  double least = -1.0;
  for (const auto& f : faces) {
    const Vec3d &a = whole.p[f[0]], &b = whole.p[f[1]], &c = whole.p[f[2]];
    const Vec3d n = cross(b - a, c - a);
    const double inside = dot(n, whole.p[f[3]] - a), origin = -dot(n, a);
    if (inside * origin > 0.0) continue;  // the origin is on the side of the fourth point
    Simplex face{3, {a, b, c, {}}};
    const Vec3d nearest = nearest_of_triangle(face);
    const double squared = norm_squared(nearest);
    if (least >= 0.0 && !(squared < least)) continue;
    best = nearest;
    least = squared;
    simplex = face;
  }
  return best;
}

}  // namespace

Vec3d nearest_of(Simplex& simplex) noexcept {
  switch (simplex.count) {
    case 1:
      return simplex.p[0];
    case 2:
      return nearest_of_segment(simplex);
    case 3:
      return nearest_of_triangle(simplex);
    default:
      return nearest_of_tetrahedron(simplex);
  }
}

}  // namespace tactus::physics
