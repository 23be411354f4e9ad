#include "tools/import/solid_distance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include "tools/import/hull_shapes.h"

namespace tactus::scene_import {
namespace {

constexpr std::uint32_t kMostInLeaf = 4;

double distance_to_box(const Vec3d& p, const physics::Aabb& box) {
  Vec3d d;
  for (int i = 0; i < 3; ++i) d[i] = std::max({box.lower[i] - p[i], 0.0, p[i] - box.upper[i]});
  return norm(d);
}

// True where the line from p along `inverse` (1 over its direction) meets the box at or after p.
bool meets_box(const Vec3d& p, const Vec3d& inverse, const physics::Aabb& box) {
  double from = 0, to = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const double a = (box.lower[i] - p[i]) * inverse[i], b = (box.upper[i] - p[i]) * inverse[i];
    from = std::max(from, std::min(a, b));
    to = std::min(to, std::max(a, b));
  }
  return from <= to;
}

// +1 where the ray leaves through the triangle, -1 where it enters, else 0 (Moller and Trumbore 1997).
int crossing(const Vec3d& p, const Vec3d& along, const std::array<Vec3d, 3>& t) {
  const Vec3d ab = t[1] - t[0], ac = t[2] - t[0], h = cross(along, ac);
  const double size = dot(ab, h);
  if (size == 0) return 0;
  const Vec3d s = p - t[0], q = cross(s, ab);
  const double u = dot(s, h) / size, v = dot(along, q) / size;
  if (u < 0 || v < 0 || u + v > 1 || dot(ac, q) / size <= 0) return 0;
  return dot(along, cross(ab, ac)) > 0 ? 1 : -1;
}

// True where all corners of b are on one side of a's plane.
bool is_beside(const std::array<Vec3d, 3>& a, const std::array<Vec3d, 3>& b, double rounding_m) {
  const Vec3d normal = normalized_or(cross(a[1] - a[0], a[2] - a[0]), Vec3d{});
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const Vec3d& corner : b) {
    const double height = dot(normal, corner - a[0]);
    least = std::min(least, height);
    most = std::max(most, height);
  }
  return least > -rounding_m || most < rounding_m;
}

struct Part {
  std::array<Vec3d, 3> corner;
  double most_m{0};  // no point of it is further from the solid
};

std::pair<Part, Part> halves(const Part& part) {
  std::size_t longest = 0;
  double most = 0;
  for (std::size_t k = 0; k < 3; ++k)
    if (const double l = norm_squared(part.corner[(k + 1) % 3] - part.corner[k]); l > most) {
      most = l;
      longest = k;
    }
  const Vec3d &a = part.corner[longest], &b = part.corner[(longest + 1) % 3], &c = part.corner[(longest + 2) % 3];
  const Vec3d middle = 0.5 * (a + b);
  return {{{a, middle, c}}, {{middle, b, c}}};
}

// Sets the part's bound, and the excess where its middle is further than all before.
void measure(Part& part, const SolidDistance& solid, double tolerance_m, Excess& excess) {
  const Vec3d middle = (part.corner[0] + part.corner[1] + part.corner[2]) * (1.0 / 3);
  double radius = 0;
  for (const Vec3d& corner : part.corner) radius = std::max(radius, norm(corner - middle));
  const auto near = solid.nearest(middle);
  // The distance to one triangle is a convex function, so it is largest at a corner.
  double to_one = 0;
  for (const Vec3d& corner : part.corner) to_one = std::max(to_one, solid.distance_to(corner, near.triangle));
  part.most_m = std::min(near.distance_m + radius, to_one);
  if (part.most_m <= excess.found_m + tolerance_m) return;
  if (solid.is_inside(middle)) {
    const bool all_inside = radius <= near.distance_m || !solid.may_cross(part.corner);
    part.most_m = all_inside ? 0.0 : std::min(part.most_m, radius - near.distance_m);
  } else if (near.distance_m > excess.found_m) {
    excess.found_m = near.distance_m;
    excess.at = middle;
  }
}

}  // namespace

SolidDistance::SolidDistance(const sim::TriangleSoup& soup) {
  for (const auto& t : soup.triangles)
    triangles_.push_back({soup.corners[t[0]], soup.corners[t[1]], soup.corners[t[2]]});
  build(0, static_cast<std::uint32_t>(triangles_.size()));
  rounding_m_ = kHullRounding * norm(nodes_[0].box.upper - nodes_[0].box.lower);
}

std::uint32_t SolidDistance::build(std::uint32_t first, std::uint32_t count) {
  const auto at = static_cast<std::uint32_t>(nodes_.size());
  nodes_.emplace_back();
  Node node{box_of(std::span(triangles_).subspan(first, count)), first, count, 0};
  if (count > kMostInLeaf) {
    const Vec3d size = node.box.upper - node.box.lower;
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (size[k] > size[axis]) axis = k;
    const auto begin = triangles_.begin() + first;
    std::stable_sort(begin, begin + count, [axis](const auto& a, const auto& b) {
      return a[0][axis] + a[1][axis] + a[2][axis] < b[0][axis] + b[1][axis] + b[2][axis];
    });
    node.count = 0;
    build(first, count / 2);
    node.second = build(first + count / 2, count - count / 2);
  }
  nodes_[at] = node;
  return at;
}

double SolidDistance::distance_to(const Vec3d& p, std::uint32_t triangle) const {
  const auto& t = triangles_[triangle];
  return scene_import::distance_to_triangle(p, t[0], t[1], t[2]);
}

SolidDistance::Nearest SolidDistance::nearest(const Vec3d& p) const {
  Nearest best{std::numeric_limits<double>::infinity(), 0};
  look(p, 0, best);
  return best;
}

void SolidDistance::look(const Vec3d& p, std::uint32_t at, Nearest& best) const {
  const Node& node = nodes_[at];
  if (distance_to_box(p, node.box) >= best.distance_m) return;
  for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
    if (const double d = distance_to(p, i); d < best.distance_m) best = {d, i};
  if (node.count > 0) return;
  const Node &a = nodes_[at + 1], &b = nodes_[node.second];
  const bool swap = distance_to_box(p, b.box) < distance_to_box(p, a.box);
  look(p, swap ? node.second : at + 1, best);
  look(p, swap ? at + 1 : node.second, best);
}

int SolidDistance::leavings(const Vec3d& p, const Vec3d& along) const {
  const Vec3d inverse{1 / along.x, 1 / along.y, 1 / along.z};
  int sum = 0;
  std::vector<std::uint32_t> open{0};
  while (!open.empty()) {
    const std::uint32_t at = open.back();
    const Node& node = nodes_[at];
    open.pop_back();
    if (!meets_box(p, inverse, node.box)) continue;
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i) sum += crossing(p, along, triangles_[i]);
    if (node.count == 0) open.insert(open.end(), {node.second, at + 1});
  }
  return sum;
}

bool SolidDistance::may_cross(const std::array<Vec3d, 3>& part) const {
  const physics::Aabb box = box_of(part);
  std::vector<std::uint32_t> open{0};
  while (!open.empty()) {
    const std::uint32_t at = open.back();
    const Node& node = nodes_[at];
    open.pop_back();
    if (!node.box.overlaps(box)) continue;
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
      if (!is_beside(triangles_[i], part, rounding_m_) && !is_beside(part, triangles_[i], rounding_m_)) return true;
    if (node.count == 0) open.insert(open.end(), {node.second, at + 1});
  }
  return false;
}

bool SolidDistance::is_inside(const Vec3d& p) const {
  // Three directions that no symmetry of a usual solid has.
  constexpr Vec3d kAlong[] = {{0.5377, 0.3119, 0.7831}, {-0.6173, 0.7321, -0.2879}, {0.2713, -0.8537, 0.4441}};
  int votes = 0;
  for (int i = 0; i < 3; ++i) {
    votes += leavings(p, kAlong[i]) != 0 ? 1 : -1;
    if (std::abs(votes) > 1) break;
  }
  return votes > 0;
}

Excess excess_of(const sim::TriangleSoup& surface, const SolidDistance& solid, double tolerance_m, unsigned divisions) {
  const auto less = [](const Part& a, const Part& b) { return a.most_m < b.most_m; };
  std::priority_queue<Part, std::vector<Part>, decltype(less)> open(less);
  Excess excess;
  const auto take = [&](Part part) {
    measure(part, solid, tolerance_m, excess);
    if (part.most_m > excess.found_m + tolerance_m)
      open.push(part);
    else
      excess.bound_m = std::max(excess.bound_m, part.most_m);
  };
  for (const auto& t : surface.triangles) take({{surface.corners[t[0]], surface.corners[t[1]], surface.corners[t[2]]}});
  for (unsigned i = 0; i < divisions && !open.empty(); ++i) {
    const Part part = open.top();
    if (part.most_m <= excess.found_m + tolerance_m) break;
    open.pop();
    const auto [first, second] = halves(part);
    take(first);
    take(second);
  }
  excess.bound_m = std::max(excess.bound_m, excess.found_m);
  if (!open.empty()) excess.bound_m = std::max(excess.bound_m, open.top().most_m);
  return excess;
}

}  // namespace tactus::scene_import
