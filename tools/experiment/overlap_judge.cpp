#include "tools/experiment/overlap_judge.h"

#include <algorithm>
#include <numeric>

#include "rt/physics/collision/collide_mesh.h"
#include "rt/physics/overlap.h"
#include "rt/physics/shapes/mesh_query.h"
#include "tools/experiment/scene_shapes.h"

namespace tactus::experiment {

using physics::Shape;

OverlapJudge::OverlapJudge(const BoxScene& scene)
    : hulls_(scene.hulls),
      terrain_(scene.terrain),
      bodies_(static_cast<std::uint32_t>(scene.cubes.size())),
      grid_(bodies_ + rods_of(scene)),
      pairs_(kMaxPairs * (bodies_ + rods_of(scene))),
      depth_m_(bodies_),
      share_(bodies_) {
  for (const Cube& cube : scene.cubes) shapes_.push_back(shape_of(scene, cube));
  shapes_.resize(bodies_ + rods_of(scene), scene.stirrer ? Shape::box(scene.stirrer->half_extents_m) : Shape{});
  for (const Wall& wall : scene.walls) {
    wall_shapes_.push_back(Shape::box(wall.half_extents_m));
    wall_poses_.push_back({wall.position, wall.rotation});
  }
  poses_.reserve(shapes_.size());
  bounds_.reserve(shapes_.size());
}

void OverlapJudge::judge_terrain(std::uint32_t a) {
  const physics::Mesh& mesh = terrain_->mesh;
  const Posed& from_mesh = terrain_->given_from_body;
  physics::TriangleList near;
  physics::find_triangles(mesh, physics::bounds_of(shapes_[a], physics::relative_pose(from_mesh, poses_[a]), 0.0),
                          near);
  double depth = 0;
  for (const std::uint32_t& triangle : near.triangles) {  // each is a patch of its own on rough ground
    const auto manifold =
        physics::collide_patch({shapes_[a], poses_[a]}, {mesh, from_mesh, {&triangle, 1}}, {.margin = 0.0}, hulls_);
    for (std::uint32_t i = 0; i < manifold.count; ++i) depth = std::max(depth, -manifold.points[i].separation);
  }
  depth_m_[a] = std::max(depth_m_[a], depth);
  share_[a] = std::max(share_[a], depth / physics::thickness(shapes_[a]));
}

// `b`: kNoBody for a wall or a rod.
void OverlapJudge::judge_pair(std::uint32_t a, const Shape& shape_b, const Posed& pose_b, std::uint32_t b) {
  physics::AxisCache cache;
  const auto manifold = physics::collide({shapes_[a], poses_[a]}, {shape_b, pose_b}, {.margin = 0.0}, cache, hulls_);
  double depth = 0;
  for (std::uint32_t i = 0; i < manifold.count; ++i) depth = std::max(depth, -manifold.points[i].separation);
  const double share = depth / std::min(physics::thickness(shapes_[a]), physics::thickness(shape_b));
  for (const std::uint32_t body : {a, b}) {
    if (body == kNoBody) continue;
    depth_m_[body] = std::max(depth_m_[body], depth);
    share_[body] = std::max(share_[body], share);
  }
}

Overlaps OverlapJudge::judge(std::span<const Posed> bodies, std::span<const Posed> rods) {
  poses_.assign(bodies.begin(), bodies.end());
  poses_.insert(poses_.end(), rods.begin(), rods.end());
  TACTUS_CHECK(poses_.size() == shapes_.size(), poses_.size(), shapes_.size());
  std::fill(depth_m_.begin(), depth_m_.end(), 0.0);
  std::fill(share_.begin(), share_.end(), 0.0);
  bounds_.clear();
  for (std::size_t i = 0; i < poses_.size(); ++i) bounds_.push_back(physics::bounds_of(shapes_[i], poses_[i], 0.0));
  pairs_.clear();
  Overlaps overlaps;
  overlaps.complete = grid_.find(bounds_, pairs_);
  for (const auto& [p, q] : pairs_) {
    const auto [a, b] = std::minmax(p, q);
    if (a < bodies_) judge_pair(a, shapes_[b], poses_[b], b < bodies_ ? b : kNoBody);
  }
  for (std::uint32_t i = 0; i < bodies_; ++i) {
    overlaps.complete = overlaps.complete && is_finite(poses_[i]);
    if (terrain_) judge_terrain(i);
    for (std::size_t w = 0; w < wall_shapes_.size(); ++w) judge_pair(i, wall_shapes_[w], wall_poses_[w], kNoBody);
  }
  if (bodies_ == 0) return overlaps;
  overlaps.deepest_m = *std::max_element(depth_m_.begin(), depth_m_.end());
  overlaps.deepest_share = *std::max_element(share_.begin(), share_.end());
  overlaps.mean_m = std::accumulate(depth_m_.begin(), depth_m_.end(), 0.0) / bodies_;
  overlaps.mean_share = std::accumulate(share_.begin(), share_.end(), 0.0) / bodies_;
  return overlaps;
}

}  // namespace tactus::experiment
