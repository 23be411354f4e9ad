#include "sim/exchange/mesh_neighbourhood.h"

namespace tactus::sim {
namespace {

// Covers the sub-world's contact margin and the motion that gravity adds in two cycles.
constexpr double kSlack_m = 2e-3;

// False if the capacity is too small.
bool add_region(BodyId body, std::uint32_t mesh_index, const physics::Mesh& mesh, const physics::Aabb& box,
                haptics::WorldSnapshot& next) noexcept {
  if (!box.overlaps({-mesh.half_extents, mesh.half_extents})) return true;
  physics::TriangleList found;
  find_triangles(mesh, box, found);
  if (found.left_out > 0) return false;
  auto& triangles = next.near_triangles;
  if (triangles.capacity() - triangles.size() < found.triangles.size()) return false;
  const std::uint32_t first = triangles.size(), count = found.triangles.size();
  if (!next.near_regions.try_push({.body = body, .mesh = mesh_index, .first = first, .count = count, .box = box}))
    return false;
  for (const std::uint32_t triangle : found.triangles) (void)triangles.try_push(triangle);
  return true;
}

}  // namespace

void fill_near_triangles(const SubWorldBodies& sub_world, std::span<const physics::Body> fixed_bodies,
                         physics::Meshes meshes, const ReachSettings& reach, haptics::WorldSnapshot& next) noexcept {
  next.near_regions.clear();
  next.near_triangles.clear();
  if (meshes.empty()) return;
  for (const BodyIndex index : sub_world.members) {
    const physics::Body& body = sub_world.bodies[index];
    const double radius_m = bounding_radius(body.shape);
    const double moves_m =
        kSlack_m + (index == sub_world.proxy ? reach_of_proxy_m(reach, radius_m)
                                             : reach_of_body_m(reach, body.motion.velocity, radius_m));
    for (const auto& fixed : fixed_bodies) {  // by id, hence in the order of the meshes
      if (fixed.shape.kind != physics::ShapeKind::kMesh) continue;
      const Posed pose = physics::relative_pose(fixed.motion.pose, body.motion.pose);
      const auto box = physics::bounds_of(body.shape, pose, moves_m);
      if (!add_region(body.id, fixed.shape.index, meshes[fixed.shape.index], box, next)) ++next.dropped;
    }
  }
}

}  // namespace tactus::sim
