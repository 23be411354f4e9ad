#include "tools/import/hull_shapes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/geometry/hull_builder.h"

namespace tactus::scene_import {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kDirections = 20'000;        // in which two convex surfaces are compared
constexpr double kSameSurface_m = 1e-9;    // deviations below are rounding
constexpr double kThinEnoughShare = 1e-6;  // of the size: points closer to the hull than this lie on it

// Directions that cover the sphere evenly (Fibonacci's spiral).
Vec3d direction(int i) {
  const double z = 1 - (2 * i + 1.0) / kDirections, angle = i * kPi * (3 - std::sqrt(5.0));
  const double r = std::sqrt(1 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

double support_of(std::span<const Vec3d> points, const Vec3d& n) {
  double most = -std::numeric_limits<double>::infinity();
  for (const Vec3d& p : points) most = std::max(most, dot(p, n));
  return most;
}

// The Hausdorff distance of two convex bodies is the largest difference of their support functions.
template <class Support>
double deviation(std::span<const Vec3d> points, const Support& support) {
  double most = 0;
  for (int i = 0; i < kDirections; ++i) {
    const Vec3d n = direction(i);
    most = std::max(most, std::abs(support_of(points, n) - support(n)));
  }
  return most;
}

// The 62 unit vectors from an icosahedron's centre to its corners, and to the middles of its faces and edges, with
// three of its twofold axes along x, y and z.
std::vector<Vec3d> icosahedral_directions() {
  const double golden = std::numbers::phi;
  std::vector<Vec3d> all;
  const auto add_turned = [&all](double a, double b, double c) {
    for (const double sa : {1.0, -1.0})
      for (const double sb : {1.0, -1.0})
        for (const double sc : {1.0, -1.0}) {
          const Vec3d v = normalized_or(Vec3d{sa * a, sb * b, sc * c}, Vec3d{});
          for (const Vec3d& w : {v, Vec3d{v.z, v.x, v.y}, Vec3d{v.y, v.z, v.x}})
            if (std::none_of(all.begin(), all.end(), [&](const Vec3d& o) { return norm(o - w) < 1e-6; }))
              all.push_back(w);
        }
  };
  add_turned(0, 1, golden);                // 12 corners
  add_turned(1, 1, 1);                     // 20 faces, with the next
  add_turned(0, golden, 1 / golden);       //
  add_turned(1, 0, 0);                     // 30 edges, with the next
  add_turned(1, golden, golden * golden);  //
  return all;
}

void extend(physics::Aabb& box, const Vec3d& p) {
  for (int k = 0; k < 3; ++k) {
    box.lower[k] = std::min(box.lower[k], p[k]);
    box.upper[k] = std::max(box.upper[k], p[k]);
  }
}

double distance_to_segment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d d = b - a;
  const double length = norm_squared(d);
  const double t = length > 0 ? std::clamp(dot(p - a, d) / length, 0.0, 1.0) : 0.0;
  return norm(p - (a + t * d));
}

Vec3d in_given(const sim::BuiltHull& built, std::uint32_t vertex) {
  return built.given_from_body.position + rotate(built.given_from_body.rotation, built.hull.vertex(vertex));
}

sim::TriangleSoup soup_of(const sim::BuiltHull& built) {
  sim::TriangleSoup soup;
  for (std::uint32_t i = 0; i < built.hull.topology.vertices; ++i) soup.corners.push_back(in_given(built, i));
  for (std::uint32_t face = 0; face < built.hull.topology.faces; ++face) {
    const auto loop = built.hull.topology.loop(face);
    for (std::size_t k = 1; k + 1 < loop.size(); ++k) soup.triangles.push_back({loop[0], loop[k], loop[k + 1]});
  }
  return soup;
}

// How far a point is above the highest of the faces' planes.
double above(const sim::BuiltHull& built, const Vec3d& given) {
  const Vec3d p = rotate_inverse(built.given_from_body.rotation, given - built.given_from_body.position);
  double most = -std::numeric_limits<double>::infinity();
  for (std::uint32_t face = 0; face < built.hull.topology.faces; ++face)
    most = std::max(most, dot(p, built.hull.normal(face)) - built.hull.offsets[face]);
  return most;
}

// A tetrahedron of points that are far apart; fewer than four points: there is none.
std::vector<Vec3d> first_points(std::span<const Vec3d> points) {
  const auto farthest = [&points](const auto& measure) {
    return *std::max_element(points.begin(), points.end(),
                             [&](const Vec3d& a, const Vec3d& b) { return measure(a) < measure(b); });
  };
  const Vec3d a = farthest([&](const Vec3d& p) { return norm_squared(p - points.front()); });
  const Vec3d b = farthest([&](const Vec3d& p) { return norm_squared(p - a); });
  const Vec3d c = farthest([&](const Vec3d& p) { return norm_squared(cross(p - a, b - a)); });
  const Vec3d n = cross(b - a, c - a);
  const Vec3d d = farthest([&](const Vec3d& p) { return std::abs(dot(p - a, n)); });
  return {a, b, c, d};
}

Result<HullPoints> thinned(std::span<const Vec3d> points) {
  std::vector<Vec3d> kept = first_points(points);
  const double size = extent_of(points);
  for (const Vec3d* added = nullptr;;) {
    auto built = sim::build_hull(kept);
    if (!built.ok()) return built.status();
    const Vec3d* farthest = nullptr;
    double most = kThinEnoughShare * size;
    for (const Vec3d& p : points) {
      const double height = above(built.value(), p);
      if (height <= most) continue;
      most = height;
      farthest = &p;
    }
    // Stops if the point that was added last made no vertex: it is within rounding of one.
    if (farthest != nullptr && farthest != added && built.value().hull.topology.vertices < physics::kMaxHullVertices) {
      added = farthest;
      kept = built.value().vertices;
      kept.push_back(*farthest);
      continue;
    }
    HullPoints out{built.value().vertices, 0};
    const sim::TriangleSoup surface = soup_of(built.value());
    // The distance to a convex body is a convex function: its largest value over the whole hull is at a point.
    for (const Vec3d& p : points)
      if (above(built.value(), p) > out.deviation_m)
        out.deviation_m = std::max(out.deviation_m, distance_to(p, surface));
    return out;
  }
}

}  // namespace

physics::Aabb box_of(std::span<const Vec3d> points) {
  physics::Aabb box{points.front(), points.front()};
  for (const Vec3d& p : points) extend(box, p);
  return box;
}

physics::Aabb box_of(std::span<const std::array<Vec3d, 3>> triangles) {
  physics::Aabb box = box_of(triangles.front());
  for (const auto& t : triangles)
    for (const Vec3d& corner : t) extend(box, corner);
  return box;
}

double extent_of(std::span<const Vec3d> points) {
  double extent = 0;
  for (const Vec3d& p : points) extent = std::max(extent, norm(p - points.front()));
  return extent;
}

HullPoints ellipsoid_hull(const Vec3d& half_axes) {
  HullPoints out;
  const std::vector<Vec3d> units = icosahedral_directions();
  const double inside = deviation(units, [](const Vec3d&) { return 1.0; });
  const double grown = 1 / (1 - inside / 2);
  for (const Vec3d& u : units) out.points.push_back(grown * scale(half_axes, u));
  out.deviation_m = deviation(out.points, [&](const Vec3d& n) { return norm(scale(half_axes, n)); });
  return out;
}

Result<HullPoints> hull_of(std::span<const Vec3d> points) {
  if (points.size() < 4) return Status::error("fewer than 4 points make no solid");
  auto built = sim::build_hull(points);
  if (built.ok()) return HullPoints{built.value().vertices, 0};
  auto made = thinned(points);
  if (made.ok() && made.value().deviation_m < kSameSurface_m) made.value().deviation_m = 0;
  return made;
}

Result<sim::TriangleSoup> surface_of(std::span<const Vec3d> points) {
  auto built = sim::build_hull(points);
  if (!built.ok()) return built.status();
  return soup_of(built.value());
}

double distance_to_triangle(const Vec3d& p, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  const Vec3d n = cross(b - a, c - a);
  const double size = norm(n);
  if (size > 0) {
    const bool inside =
        dot(cross(b - a, p - a), n) >= 0 && dot(cross(c - b, p - b), n) >= 0 && dot(cross(a - c, p - c), n) >= 0;
    if (inside) return std::abs(dot(p - a, n)) / size;
  }
  return std::min({distance_to_segment(p, a, b), distance_to_segment(p, b, c), distance_to_segment(p, c, a)});
}

double distance_to(const Vec3d& point, const sim::TriangleSoup& surface) {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& t : surface.triangles)
    least = std::min(least,
                     distance_to_triangle(point, surface.corners[t[0]], surface.corners[t[1]], surface.corners[t[2]]));
  return least;
}

}  // namespace tactus::scene_import
