#include "tools/import/fragment.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "tools/import/hull_shapes.h"

namespace tactus::scene_import {
namespace {

constexpr double kCreaseSine = 1e-3;       // of the angle between two triangles: less is flat
constexpr double kParallel = 1e-9;         // volume that three unit normals span: with less their planes have no corner
constexpr std::size_t kCreasesToTry = 10;  // of a fragment; each has three planes

bool lower(const Vec3d& a, const Vec3d& b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); }

Vec3d normal_of(const std::array<Vec3d, 3>& t) { return cross(t[1] - t[0], t[2] - t[0]); }

// Where the plane cuts the edge; the same for both directions of the edge.
Vec3d between(const Vec3d& a, double height_a, const Vec3d& b, double height_b) {
  if (lower(b, a)) return between(b, height_b, a, height_a);
  return a + (height_a / (height_a - height_b)) * (b - a);
}

// The corners of a triangle on one side of the plane (sign: -1 below, +1 above) and the crossings.
std::vector<Vec3d> side_of(const std::array<Vec3d, 3>& corners, const std::array<double, 3>& heights, double sign) {
  std::vector<Vec3d> out;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::size_t next = (k + 1) % 3;
    if (sign * heights[k] >= 0) out.push_back(corners[k]);
    if (heights[k] * heights[next] < 0) out.push_back(between(corners[k], heights[k], corners[next], heights[next]));
  }
  return out;
}

void add_cut(const Fragment& fragment, const Plane& plane, Fragment& side) {
  side.cuts = fragment.cuts;
  side.cuts.push_back(plane);
}

// Where the plane meets two cuts inside of the solid, in the fragment.
std::vector<Vec3d> new_corners(const Fragment& fragment, const Plane& plane, const SolidDistance& solid,
                               double rounding_m) {
  std::vector<Vec3d> corners;
  const auto& cuts = fragment.cuts;
  for (std::size_t i = 0; i < cuts.size(); ++i)
    for (std::size_t k = i + 1; k < cuts.size(); ++k) {
      const Vec3d &a = plane.normal, &b = cuts[i].normal, &c = cuts[k].normal;
      const double volume = dot(a, cross(b, c));
      if (std::abs(volume) < kParallel) continue;
      const Vec3d p =
          (plane.offset * cross(b, c) + cuts[i].offset * cross(c, a) + cuts[k].offset * cross(a, b)) * (1 / volume);
      const auto is_below = [&](const Plane& other) { return dot(other.normal, p) - other.offset <= rounding_m; };
      if (std::ranges::all_of(cuts, is_below) && solid.is_inside(p)) corners.push_back(p);
    }
  return corners;
}

void add_fan(const std::vector<Vec3d>& polygon, Fragment& fragment) {
  for (std::size_t k = 1; k + 1 < polygon.size(); ++k)
    fragment.triangles.push_back({polygon[0], polygon[k], polygon[k + 1]});
}

bool add_new(const Plane& plane, double rounding_m, std::vector<Plane>& planes) {
  constexpr double kSameDirection = 1e-9;  // of 1 - |cosine|: directions equal to 1e-4 rad
  for (const Plane& other : planes) {
    const double cosine = dot(plane.normal, other.normal);
    if (1 - std::abs(cosine) < kSameDirection &&
        std::abs(plane.offset - std::copysign(other.offset, cosine * other.offset)) < rounding_m)
      return false;
  }
  planes.push_back(plane);
  return true;
}

}  // namespace

Fragment whole_of(const sim::TriangleSoup& soup) {
  Fragment whole;
  struct Side {
    Vec3d normal, opposite;
  };
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::vector<Side>> edges;
  for (const auto& t : soup.triangles) {
    const std::array<Vec3d, 3> corners{soup.corners[t[0]], soup.corners[t[1]], soup.corners[t[2]]};
    const Vec3d normal = normalized_or(normal_of(corners), Vec3d{});
    if (normal == Vec3d{}) continue;
    whole.triangles.push_back(corners);
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = t[k], b = t[(k + 1) % 3];
      edges[{std::min(a, b), std::max(a, b)}].push_back({normal, corners[(k + 2) % 3]});
    }
  }
  for (const auto& [edge, sides] : edges) {
    if (sides.size() != 2) continue;
    const Vec3d& a = soup.corners[edge.first];
    const Vec3d other = sides[1].opposite - a;
    if (norm(cross(sides[0].normal, sides[1].normal)) > kCreaseSine && dot(sides[0].normal, other) > 0)
      whole.creases.push_back({a, soup.corners[edge.second], {sides[0].normal, sides[1].normal}});
  }
  return whole;
}

std::vector<Vec3d> corners_of(const Fragment& fragment) {
  std::vector<Vec3d> corners;
  for (const auto& t : fragment.triangles) corners.insert(corners.end(), t.begin(), t.end());
  corners.insert(corners.end(), fragment.inner_corners.begin(), fragment.inner_corners.end());
  std::sort(corners.begin(), corners.end(), lower);
  corners.erase(std::unique(corners.begin(), corners.end()), corners.end());
  return corners;
}

Cut cut(const Fragment& fragment, const Plane& plane, const SolidDistance& solid, double rounding_m) {
  Cut out;
  add_cut(fragment, plane, out.below);
  add_cut(fragment, {-plane.normal, -plane.offset}, out.above);
  const auto height = [&](const Vec3d& p) {
    const double h = dot(plane.normal, p) - plane.offset;
    return std::abs(h) < rounding_m ? 0.0 : h;
  };
  for (const Vec3d& corner : fragment.inner_corners) {
    if (height(corner) <= 0) out.below.inner_corners.push_back(corner);
    if (height(corner) >= 0) out.above.inner_corners.push_back(corner);
  }
  for (const Vec3d& corner : new_corners(fragment, plane, solid, rounding_m)) {
    out.below.inner_corners.push_back(corner);
    out.above.inner_corners.push_back(corner);
  }
  for (const auto& t : fragment.triangles) {
    const std::array<double, 3> heights{height(t[0]), height(t[1]), height(t[2])};
    const auto [least, most] = std::minmax_element(heights.begin(), heights.end());
    if (*least == 0 && *most == 0)
      (dot(normal_of(t), plane.normal) > 0 ? out.below : out.above).triangles.push_back(t);
    else if (*most <= 0)
      out.below.triangles.push_back(t);
    else if (*least >= 0)
      out.above.triangles.push_back(t);
    else {
      add_fan(side_of(t, heights, -1), out.below);
      add_fan(side_of(t, heights, 1), out.above);
    }
  }
  for (const Crease& crease : fragment.creases) {
    const double a = height(crease.a), b = height(crease.b);
    if (a == 0 && b == 0) continue;  // it is a rim now
    if (a <= 0 && b <= 0) {
      out.below.creases.push_back(crease);
    } else if (a >= 0 && b >= 0) {
      out.above.creases.push_back(crease);
    } else {
      Crease first = crease, second = crease;
      first.b = second.a = between(crease.a, a, crease.b, b);
      (a < 0 ? out.below : out.above).creases.push_back(first);
      (a < 0 ? out.above : out.below).creases.push_back(second);
    }
  }
  return out;
}

std::vector<Plane> planes_to_try(const Fragment& fragment, const Vec3d& worst, double rounding_m) {
  std::vector<Plane> planes;
  const auto add_crease = [&](const Crease& crease) {
    const Vec3d middle = 0.5 * (crease.a + crease.b);
    bool is_new = false;
    for (const Vec3d& n : {crease.normals[0], crease.normals[1], crease.normals[0] - crease.normals[1]}) {
      const Vec3d normal = normalized_or(n, Vec3d{});
      is_new = add_new({normal, dot(normal, middle)}, rounding_m, planes) || is_new;
    }
    return is_new;
  };
  const std::size_t count = fragment.creases.size();
  if (count > 0) {
    const auto distance = [&](const Crease& c) { return norm_squared(0.5 * (c.a + c.b) - worst); };
    add_crease(*std::min_element(fragment.creases.begin(), fragment.creases.end(),
                                 [&](const Crease& a, const Crease& b) { return distance(a) < distance(b); }));
    std::size_t added = 1;
    // Steps of the golden section visit a list evenly, whenever they end.
    for (std::size_t i = 0; i < count && added < kCreasesToTry; ++i) {
      const double share = 0.6180339887498949 * static_cast<double>(i + 1);
      const auto at = static_cast<std::size_t>((share - std::floor(share)) * static_cast<double>(count));
      if (add_crease(fragment.creases[std::min(at, count - 1)])) ++added;
    }
  }
  const auto [low, high] = box_of(fragment.triangles);
  for (int k = 0; k < 3; ++k) {
    Vec3d normal;
    normal[k] = 1;
    for (const double share : {0.25, 0.5, 0.75})
      add_new({normal, low[k] + share * (high[k] - low[k])}, rounding_m, planes);
    add_new({normal, worst[k]}, rounding_m, planes);
  }
  return planes;
}

}  // namespace tactus::scene_import
