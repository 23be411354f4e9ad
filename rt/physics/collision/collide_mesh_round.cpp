// The kernels of sphere and capsule against a patch of a mesh, in the mesh's frame.
#include <limits>

#include "rt/physics/collision/collide_mesh.h"
#include "rt/physics/collision/hull_closest.h"
#include "rt/physics/shapes/mesh_region.h"
#include "rt/physics/shapes/segments.h"

namespace tactus::physics {
namespace {

// The point of a triangle nearest to a point in front of it, and what may push there.
struct NearestOnTriangle {
  Ruling ruling{Ruling::kDropped};
  Vec3d point;
  double distance{};  // along the normal for a face
};

NearestOnTriangle nearest_on_triangle(const Mesh& mesh, std::uint32_t triangle, const Vec3d& c) noexcept {
  const MeshTriangle& t = mesh.triangles[triangle];
  const Vec3d& n = mesh.normals[triangle];
  const double height = dot(n, c - mesh.corners[t.corner[0]]);
  if (!(height > 0.0)) return {};
  const NearestOnTriangle face{Ruling::kFace, c - n * height, height};
  bool beyond_any = false, at_corner = false;
  std::uint32_t feature = 0;
  Vec3d nearest;
  double least = std::numeric_limits<double>::infinity();
  for (std::uint32_t k = 0; k < 3; ++k) {
    const Vec3d& from = mesh.corners[t.corner[k]];
    const Vec3d along = mesh.corners[t.corner[k == 2 ? 0 : k + 1]] - from;
    if (!(dot(cross(along, n), c - from) > 0.0)) continue;
    beyond_any = true;
    const double share = dot(c - from, along) / norm_squared(along);
    const double clamped = smaller(1.0, larger(0.0, share));
    const Vec3d point = from + along * clamped;
    const double squared = norm_squared(c - point);
    if (!(squared < least)) continue;
    least = squared;
    nearest = point;
    at_corner = clamped != share;
    feature = at_corner && clamped > 0.0 ? (k == 2 ? 0 : k + 1) : k;
  }
  if (!beyond_any) return face;
  const Vec3d d = c - nearest;
  const Ruling ruling =
      at_corner ? rule_corner(mesh, triangle, t.corner[feature], d) : rule_edge(mesh, triangle, feature, d);
  if (ruling == Ruling::kFace) return face;
  return {ruling, nearest, std::sqrt(least)};
}

// The part of a capsule's axis above a triangle.
struct Stretch {
  LineRange range;
  std::uint32_t low_edge{kOwnEnd}, high_edge{kOwnEnd};  // the triangle's edge that limits the range there
  static constexpr std::uint32_t kOwnEnd = 3;
};

Stretch stretch_above(const Mesh& mesh, std::uint32_t triangle, const Vec3d& centre, const Vec3d& half) noexcept {
  Stretch stretch;
  const MeshTriangle& t = mesh.triangles[triangle];
  for (std::uint32_t k = 0; k < 3; ++k) {
    const Vec3d outward = outward_of_edge(mesh, triangle, k);
    const LineRange before = stretch.range;
    // Widens each side by a rounding error, so that two triangles leave no gap at their seam.
    cut_range(stretch.range, dot(outward, centre - mesh.corners[t.corner[k]]) - 1e-9 * norm(outward),
              dot(outward, half));
    if (stretch.range.low > before.low) stretch.low_edge = k;
    if (stretch.range.high < before.high) stretch.high_edge = k;
  }
  return stretch;
}

// Collects the outermost points of the axis above the patch, and the deepest edge or corner contact.
class CapsuleOnPatch {
 public:
  CapsuleOnPatch(const PatchView& patch, const Vec3d& half, double radius) noexcept
      : patch_(patch), half_(half), radius_(radius) {}

  void look_at(std::uint32_t triangle) noexcept {
    look_at_face(triangle);
    if (patch_.mesh.triangles[triangle].exposed)
      for (std::uint32_t k = 0; k < 3; ++k) look_at_edge(triangle, k);
  }

  void finish(Manifold& manifold) const noexcept {
    const bool face = any_face_ && !(edge_distance_ + 1e-7 < least_height_);
    if (!face) {
      if (!(edge_distance_ < std::numeric_limits<double>::infinity())) return;
      const Vec3d outward = edge_direction_ * (1.0 / edge_distance_);
      patch_.set_normal(manifold, outward);
      patch_.add(manifold, edge_point_ + outward * (0.5 * (edge_distance_ - radius_)), edge_distance_ - radius_,
                 kMeshEdgeFeature);
      return;
    }
    const Vec3d& n = patch_.mesh.normals[face_];
    patch_.set_normal(manifold, n);
    const bool one = (high_.t - low_.t) * norm(half_) <= kFlatTolerance;
    const End& nearer = high_.height < low_.height ? high_ : low_;
    for (const End* end : {&low_, &high_}) {
      if (one && end != &nearer) continue;
      const double separation = end->height - radius_;
      const Vec3d mid = at(end->t) - n * (0.5 * (end->height + radius_));
      patch_.add(manifold, mid, separation, one ? kBodyFeature : end->feature);
    }
  }

 private:
  struct End {
    double t{}, height{};
    std::uint32_t feature{0};
  };

  Vec3d at(double t) const noexcept { return patch_.centre + half_ * t; }

  void look_at_face(std::uint32_t triangle) noexcept {
    const Mesh& mesh = patch_.mesh;
    const MeshTriangle& t = mesh.triangles[triangle];
    const Vec3d& n = mesh.normals[triangle];
    const auto height = [&](double s) noexcept { return dot(n, at(s) - mesh.corners[t.corner[0]]); };
    const Stretch stretch = stretch_above(mesh, triangle, patch_.centre, half_);
    if (stretch.range.empty()) return;
    const double low = height(stretch.range.low), high = height(stretch.range.high);
    // One-sided: requires that the capsule's centre, or the whole range, is in front.
    if (!(height(0.0) > 0.0 || (low > 0.0 && high > 0.0))) return;
    if (!any_face_ || smaller(low, high) < least_height_) {
      face_ = triangle;
      least_height_ = smaller(low, high);
    }
    const auto feature = [&](std::uint32_t edge, std::uint32_t own) noexcept {
      return edge == Stretch::kOwnEnd ? kBodyFeature | own : kCrossingFeature | (3 * triangle + edge);
    };
    if (!any_face_ || stretch.range.low < low_.t)
      low_ = {.t = stretch.range.low, .height = low, .feature = feature(stretch.low_edge, 1)};
    if (!any_face_ || stretch.range.high > high_.t)
      high_ = {.t = stretch.range.high, .height = high, .feature = feature(stretch.high_edge, 2)};
    any_face_ = true;
  }

  void look_at_edge(std::uint32_t triangle, std::uint32_t k) noexcept {
    const Mesh& mesh = patch_.mesh;
    const MeshTriangle& t = mesh.triangles[triangle];
    const std::uint32_t next = k == 2 ? 0 : k + 1;
    const Vec3d &from = mesh.corners[t.corner[k]], &to = mesh.corners[t.corner[next]];
    const Vec3d half_edge = 0.5 * (to - from), middle = 0.5 * (from + to);
    const auto [s, u] = closest_on_segments(half_, half_edge, middle - patch_.centre);
    const Vec3d point = middle + half_edge * u, d = at(s) - point;
    const double distance = norm(d);
    if (!(distance > kNoDirection && distance < edge_distance_ && distance - radius_ <= patch_.pair.margin)) return;
    const Ruling ruling = u == 1.0    ? rule_corner(mesh, triangle, t.corner[next], d)
                          : u == -1.0 ? rule_corner(mesh, triangle, t.corner[k], d)
                                      : rule_edge(mesh, triangle, k, d);
    // At the rim of a face, the face's own range is equally near.
    if (ruling != Ruling::kAllowed) return;
    edge_distance_ = distance;
    edge_direction_ = d;
    edge_point_ = point;
  }

  const PatchView& patch_;
  Vec3d half_;
  double radius_;
  bool any_face_{false};
  std::uint32_t face_{0};  // the face with the least height
  double least_height_{};
  End low_, high_;
  double edge_distance_{std::numeric_limits<double>::infinity()};
  Vec3d edge_direction_, edge_point_;
};

}  // namespace

void collide_sphere_patch(const PatchView& patch, Manifold& manifold) noexcept {
  NearestOnTriangle nearest;
  std::uint32_t at = 0;
  for (const std::uint32_t triangle : patch.triangles) {
    const NearestOnTriangle found = nearest_on_triangle(patch.mesh, triangle, patch.centre);
    if (found.ruling == Ruling::kDropped) continue;
    if (nearest.ruling == Ruling::kDropped || found.distance < nearest.distance) {
      nearest = found;
      at = triangle;
    }
  }
  const double separation = nearest.distance - patch.pair.a.radius;
  if (nearest.ruling == Ruling::kDropped || !(separation <= patch.pair.margin)) return;
  const Vec3d outward = nearest.ruling == Ruling::kFace
                            ? patch.mesh.normals[at]
                            : direction_or(patch.centre - nearest.point, patch.mesh.normals[at]);
  patch.set_normal(manifold, outward);
  patch.add(manifold, nearest.point + outward * (0.5 * separation), separation, kBodyFeature);
}

void collide_capsule_patch(const PatchView& patch, Manifold& manifold) noexcept {
  const Vec3d half = rotate_inverse(patch.pair.world_from_b, capsule_half_axis(patch.pair.a, patch.pair.world_from_a));
  CapsuleOnPatch capsule(patch, half, patch.pair.a.radius);
  for (const std::uint32_t triangle : patch.triangles) capsule.look_at(triangle);
  capsule.finish(manifold);
}

}  // namespace tactus::physics
