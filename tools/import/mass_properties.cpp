#include "tools/import/mass_properties.h"

#include <algorithm>
#include <cmath>

namespace tactus::scene_import {

SymMat3d rotated(const SymMat3d& m, const Quatd& rotation) {
  // Column k of M R^T is M applied to the frame's axis k, seen from inside; then R from the left.
  Vec3d column[3];
  const Vec3d units[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  for (int k = 0; k < 3; ++k) column[k] = rotate(rotation, m * rotate_inverse(rotation, units[k]));
  return {column[0].x,
          column[1].y,
          column[2].z,
          0.5 * (column[0].y + column[1].x),
          0.5 * (column[0].z + column[2].x),
          0.5 * (column[1].z + column[2].y)};
}

SymMat3d parallel_axis(const Vec3d& v) {
  const double square = norm_squared(v);
  return {square - v.x * v.x, square - v.y * v.y, square - v.z * v.z, -v.x * v.y, -v.x * v.z, -v.y * v.z};
}

double largest_difference(const SymMat3d& a, const SymMat3d& b) {
  return std::max({std::abs(a.xx - b.xx), std::abs(a.yy - b.yy), std::abs(a.zz - b.zz), std::abs(a.xy - b.xy),
                   std::abs(a.xz - b.xz), std::abs(a.yz - b.yz)});
}

MassProperties principal_mass(double mass, const Vec3d& centre, const Quatd& axes, const Vec3d& moments) {
  return {mass, centre, rotate_diagonal(axes, moments)};
}

MassProperties in_frame(const MassProperties& world, const Posed& world_from_frame) {
  return {world.mass, rotate_inverse(world_from_frame.rotation, world.centre - world_from_frame.position),
          rotated(world.inertia, conjugate(world_from_frame.rotation))};
}

MassProperties in_world(const MassProperties& own, const Posed& world_from_frame) {
  return {own.mass, world_from_frame.position + rotate(world_from_frame.rotation, own.centre),
          rotated(own.inertia, world_from_frame.rotation)};
}

MassProperties operator+(const MassProperties& a, const MassProperties& b) {
  const double mass = a.mass + b.mass;
  if (!(mass > 0)) return {};
  const Vec3d centre = (a.mass * a.centre + b.mass * b.centre) * (1 / mass);
  return {mass, centre,
          a.inertia + scaled(a.mass, parallel_axis(a.centre - centre)) + b.inertia +
              scaled(b.mass, parallel_axis(b.centre - centre))};
}

// Signed sums over the tetrahedra from the first corner to every triangle (Tonon 2004).
MassProperties solid_of(const sim::TriangleSoup& soup) {
  if (soup.corners.empty()) return {};
  const Vec3d origin = soup.corners.front();
  double volume = 0;
  Vec3d first;
  SymMat3d second;
  for (const auto& t : soup.triangles) {
    const Vec3d a = soup.corners[t[0]] - origin, b = soup.corners[t[1]] - origin, c = soup.corners[t[2]] - origin;
    const Vec3d s = a + b + c;
    const double v = dot(a, cross(b, c)) / 6, w = v / 20;
    volume += v;
    first += s * (v / 4);
    second = second + SymMat3d{w * (a.x * a.x + b.x * b.x + c.x * c.x + s.x * s.x),
                               w * (a.y * a.y + b.y * b.y + c.y * c.y + s.y * s.y),
                               w * (a.z * a.z + b.z * b.z + c.z * c.z + s.z * s.z),
                               w * (a.x * a.y + b.x * b.y + c.x * c.y + s.x * s.y),
                               w * (a.x * a.z + b.x * b.z + c.x * c.z + s.x * s.z),
                               w * (a.y * a.z + b.y * b.z + c.y * c.z + s.y * s.z)};
  }
  if (!(volume > 0)) return {};
  const Vec3d centre = first * (1 / volume);
  const SymMat3d about_origin{
      second.yy + second.zz, second.xx + second.zz, second.xx + second.yy, -second.xy, -second.xz, -second.yz};
  return {volume, origin + centre, about_origin + scaled(-volume, parallel_axis(centre))};
}

bool is_a_body(const MassProperties& p) {
  const SymMat3d& m = p.inertia;
  const double half = 0.5 * trace(m), a = half - m.xx, b = half - m.yy, c = half - m.zz, rounding = 1e-10 * half;
  return p.mass > 0 && half > 0 && std::min({a, b, c}) > -rounding && (a + rounding) * (b + rounding) >= m.xy * m.xy &&
         (a + rounding) * (c + rounding) >= m.xz * m.xz && (b + rounding) * (c + rounding) >= m.yz * m.yz;
}

}  // namespace tactus::scene_import
