#include "rt/physics/collision/hull_closest.h"

namespace tactus::physics {

LineRange range_above_face(const HullView& hull, std::uint32_t face, const Vec3d& centre, const Vec3d& half) noexcept {
  LineRange range;
  const auto loop = hull.topology->loop(face);
  Vec3d from = hull.vertex(loop[loop.size() - 1]);
  for (const std::uint8_t i : loop) {
    const Vec3d to = hull.vertex(i), outward = cross(to - from, hull.normal(face));
    cut_range(range, dot(outward, centre - from), dot(outward, half));
    from = to;
  }
  return range;
}

bool is_above_face(const HullView& hull, std::uint32_t face, const Vec3d& point) noexcept {
  const auto loop = hull.topology->loop(face);
  Vec3d from = hull.vertex(loop[loop.size() - 1]);
  for (const std::uint8_t i : loop) {
    const Vec3d to = hull.vertex(i);
    if (dot(cross(to - from, hull.normal(face)), point - from) > 0.0) return false;
    from = to;
  }
  return true;
}

HighestFace highest_face(const HullView& hull, const Vec3d& point) noexcept {
  HighestFace best{0, hull.height(0, point)};
  for (std::uint32_t f = 1; f < hull.topology->faces; ++f) {
    const double height = hull.height(f, point);
    if (height > best.height) best = {f, height};
  }
  return best;
}

Vec3d closest_on_hull(const HullView& hull, const Vec3d& point) noexcept {
  std::array<double, kMaxHullFaces> height;
  bool outside = false;
  for (std::uint32_t f = 0; f < hull.topology->faces; ++f) {
    height[f] = hull.height(f, point);
    if (!(height[f] > 0.0)) continue;
    outside = true;
    if (is_above_face(hull, f, point)) return point - hull.normal(f) * height[f];
  }
  if (!outside) return point;
  Vec3d best = point;
  double least = -1.0;
  for (std::uint32_t e = 0; e < hull.topology->edges; ++e) {
    const HullEdge& edge = hull.topology->edge[e];
    if (!(height[edge.left] > 0.0) && !(height[edge.right] > 0.0)) continue;
    const Vec3d from = hull.vertex(edge.from), along = hull.vertex(edge.to) - from;
    const double t = smaller(1.0, larger(0.0, dot(point - from, along) / norm_squared(along)));
    const Vec3d on_edge = from + along * t;
    const double distance = norm_squared(point - on_edge);
    if (least >= 0.0 && !(distance < least)) continue;
    least = distance;
    best = on_edge;
  }
  return best;
}

}  // namespace tactus::physics
