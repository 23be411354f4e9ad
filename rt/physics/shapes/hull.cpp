#include "rt/physics/shapes/hull.h"

#include <algorithm>

#include "rt/base/rotation_axes.h"
#include "rt/base/wide.h"
#include "rt/physics/shapes/hull_mass.h"
#include "rt/physics/shapes/principal_axes.h"

namespace tactus::physics {
namespace {

// Largest deviation of a face's vertices from its plane, as a share of the size: enough for files in single precision.
constexpr double kFlatShare = 1e-4;

struct Moments {
  double volume{0};  // m^3
  Vec3d first;       // m^4
  SymMat3d second;   // m^5: integral of x x^T
};

// Moments of the polyhedron about `origin`: signed sums over the tetrahedra from there to every triangle of every face.
Moments moments_about(const Vec3d& origin, std::span<const Vec3d> vertices, const HullTopology& topology) noexcept {
  Moments sum;
  for (std::uint32_t face = 0; face < topology.faces; ++face) {
    const auto loop = topology.loop(face);
    const Vec3d a = vertices[loop[0]] - origin;
    for (std::size_t k = 1; k + 1 < loop.size(); ++k) {
      const Vec3d b = vertices[loop[k]] - origin, c = vertices[loop[k + 1]] - origin, s = a + b + c;
      const double volume = dot(a, cross(b, c)) / 6;
      sum.volume += volume;
      sum.first += s * (volume / 4);
      const double w = volume / 20;
      sum.second.xx += w * (a.x * a.x + b.x * b.x + c.x * c.x + s.x * s.x);
      sum.second.yy += w * (a.y * a.y + b.y * b.y + c.y * c.y + s.y * s.y);
      sum.second.zz += w * (a.z * a.z + b.z * b.z + c.z * c.z + s.z * s.z);
      sum.second.xy += w * (a.x * a.y + b.x * b.y + c.x * c.y + s.x * s.y);
      sum.second.xz += w * (a.x * a.z + b.x * b.z + c.x * c.z + s.x * s.z);
      sum.second.yz += w * (a.y * a.z + b.y * b.z + c.y * c.z + s.y * s.z);
    }
  }
  return sum;
}

// Newell's normal: that of the plane that fits the loop best.
Vec3d normal_of(const Hull& hull, std::uint32_t face) noexcept {
  const auto loop = hull.topology.loop(face);
  const Vec3d origin = hull.vertex(loop[0]);
  Vec3d sum;
  for (std::size_t k = 1; k + 1 < loop.size(); ++k)
    sum += cross(hull.vertex(loop[k]) - origin, hull.vertex(loop[k + 1]) - origin);
  return normalized_or(sum, Vec3d{});
}

void add_planes(Hull& hull) noexcept {
  const HullTopology& topology = hull.topology;
  for (std::uint32_t face = 0; face < topology.faces; ++face) {
    const Vec3d n = normal_of(hull, face);
    double highest = dot(n, hull.vertex(0)), lowest = highest;
    for (std::uint32_t i = 1; i < topology.vertices; ++i) {
      highest = std::max(highest, dot(n, hull.vertex(i)));
      lowest = std::min(lowest, dot(n, hull.vertex(i)));
    }
    hull.nx[face] = n.x;
    hull.ny[face] = n.y;
    hull.nz[face] = n.z;
    hull.offsets[face] = highest;
    hull.inner_radius = face == 0 ? highest : std::min(hull.inner_radius, highest);
    hull.least_width = face == 0 ? highest - lowest : std::min(hull.least_width, highest - lowest);
    for (const std::uint8_t i : topology.loop(face))
      hull.flatness = std::max(hull.flatness, highest - dot(n, hull.vertex(i)));
  }
  for (std::uint32_t face = topology.faces; face < kMaxHullFaces; ++face) {
    hull.nx[face] = hull.nx[0];
    hull.ny[face] = hull.ny[0];
    hull.nz[face] = hull.nz[0];
    hull.offsets[face] = hull.offsets[0];
  }
  for (std::uint32_t e = 0; e < topology.edges; ++e) {
    const double cosine = dot(hull.normal(topology.edge[e].left), hull.normal(topology.edge[e].right));
    hull.edge_secant[e] = 1 / std::sqrt(std::max(0.5 * (1 + cosine), 1e-12));
    hull.largest_secant = std::max(hull.largest_secant, hull.edge_secant[e]);
  }
}

// The vertices in the hull's frame, padded, and what encloses them.
void place_vertices(std::span<const Vec3d> vertices, const Posed& given_from_body, Hull& hull) noexcept {
  for (std::size_t i = 0; i < kMaxHullVertices; ++i) {
    const std::size_t from = i < vertices.size() ? i : 0;
    const Vec3d v = rotate_inverse(given_from_body.rotation, vertices[from] - given_from_body.position);
    hull.x[i] = v.x;
    hull.y[i] = v.y;
    hull.z[i] = v.z;
    hull.bounding_radius = std::max(hull.bounding_radius, norm(v));
    const Vec3d extents = abs(v);
    hull.half_extents = {std::max(hull.half_extents.x, extents.x), std::max(hull.half_extents.y, extents.y),
                         std::max(hull.half_extents.z, extents.z)};
  }
}

}  // namespace

HullFault make_hull(std::span<const Vec3d> vertices, const HullTopology& topology, Hull& hull,
                    Posed& given_from_body) noexcept {
  hull = {};
  hull.topology = topology;
  hull.topology.vertices = static_cast<std::uint32_t>(vertices.size());
  if (vertices.size() > kMaxHullVertices || vertices.size() < 4 || !hull.topology.close()) return HullFault::kNotClosed;
  Vec3d middle;
  for (const Vec3d& v : vertices) middle += v * (1.0 / static_cast<double>(vertices.size()));
  if (!is_finite(middle)) return HullFault::kNotFinite;

  const Moments rough = moments_about(middle, vertices, topology);
  if (!(rough.volume > 0)) return HullFault::kFlat;
  const Vec3d centre = middle + rough.first * (1 / rough.volume);
  const Moments exact = moments_about(centre, vertices, topology);
  const Principal principal = principal_axes(exact.second);
  given_from_body = {centre, quat_from_axes(principal.axis[0], principal.axis[1], principal.axis[2])};
  hull.volume = exact.volume;
  const auto& p = principal.moment;
  hull.inertia_per_kg = Vec3d{p[1] + p[2], p[0] + p[2], p[0] + p[1]} * (1 / exact.volume);

  place_vertices(vertices, given_from_body, hull);
  add_planes(hull);
  if (!(hull.inner_radius > 0)) return HullFault::kFlat;
  if (!(hull.flatness <= kFlatShare * hull.bounding_radius)) return HullFault::kNotConvex;
  return HullFault::kNone;
}

HullFault set_mass_properties(const Vec3d& centre, const SymMat3d& inertia_per_kg, Hull& hull,
                              Posed& given_from_body) noexcept {
  std::array<Vec3d, kMaxHullVertices> vertices;
  const std::uint32_t count = hull.topology.vertices;
  for (std::uint32_t i = 0; i < count; ++i)
    vertices[i] = given_from_body.position + rotate(given_from_body.rotation, hull.vertex(i));
  const Principal principal = principal_axes(inertia_per_kg);
  given_from_body = {centre, quat_from_axes(principal.axis[0], principal.axis[1], principal.axis[2])};
  hull.inertia_per_kg = {principal.moment[0], principal.moment[1], principal.moment[2]};
  hull.bounding_radius = 0;
  hull.half_extents = {};
  place_vertices(std::span(vertices).first(count), given_from_body, hull);
  add_planes(hull);  // lengths and reaches are the same in any frame
  return hull.inner_radius > 0 ? HullFault::kNone : HullFault::kFlat;
}

}  // namespace tactus::physics
