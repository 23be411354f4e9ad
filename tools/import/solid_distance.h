// The signed distance of points to a solid that a surface encloses, and how far a second surface leaves the solid.
//
// A point is inside where a ray from it leaves the surface more often than it enters; the majority of up to three rays
// decides, so that a small hole or a ray along an edge changes nothing. Units: m. Frame: the surface's own. Thread: any
// normal one. Bound: a tree of boxes; kMaxDivisions triangles of the second surface. Errors: none.
#pragma once

#include "rt/physics/shapes/shape.h"
#include "sim/geometry/mesh_files.h"

namespace tactus::scene_import {

inline constexpr unsigned kMaxDivisions = 40'000;
inline constexpr double kHullRounding = 1e-6;  // of the size: the share at which faces of a hull are merged

class SolidDistance {
 public:
  struct Nearest {
    double distance_m;
    std::uint32_t triangle;
  };

  // At least one triangle.
  explicit SolidDistance(const sim::TriangleSoup& soup);

  Nearest nearest(const Vec3d& p) const;
  bool is_inside(const Vec3d& p) const;
  double distance_to(const Vec3d& p, std::uint32_t triangle) const;
  // False: no part of the surface goes through the triangle by more than the rounding of a hull's faces.
  bool may_cross(const std::array<Vec3d, 3>& part) const;

 private:
  struct Node {
    physics::Aabb box;
    std::uint32_t first{0}, count{0}, second{0};  // count 0: an inner node, its first child follows it
  };
  std::uint32_t build(std::uint32_t first, std::uint32_t count);
  void look(const Vec3d& p, std::uint32_t at, Nearest& best) const;
  int leavings(const Vec3d& p, const Vec3d& along) const;

  std::vector<std::array<Vec3d, 3>> triangles_;
  std::vector<Node> nodes_;
  double rounding_m_{0};
};

// The largest distance to the solid of a point of `surface`: `found_m` at the place `at`; no point is further than
// `bound_m`. Triangles are halved, largest bound first, until none can exceed `found_m` by more than `tolerance_m`, or
// `divisions` are made.
struct Excess {
  double found_m{0}, bound_m{0};
  Vec3d at;
};
Excess excess_of(const sim::TriangleSoup& surface, const SolidDistance& solid, double tolerance_m, unsigned divisions);

}  // namespace tactus::scene_import
