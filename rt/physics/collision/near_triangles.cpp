#include "rt/physics/collision/near_triangles.h"

#include <algorithm>

namespace tactus::physics {

void NearTriangles::find(const Mesh& mesh, BodyId body, std::uint32_t mesh_index, const Aabb& box, TriangleList& found,
                         BodyOnMesh* body_on_mesh) const noexcept {
  const auto before = [](const NearRegion& r, std::pair<BodyId, std::uint32_t> key) noexcept {
    return r.body != key.first ? r.body < key.first : r.mesh < key.second;
  };
  const auto at = std::lower_bound(regions.begin(), regions.end(), std::pair(body, mesh_index), before);
  const bool holds = at != regions.end() && at->body == body && at->mesh == mesh_index && at->box.holds(box);
  if (holds)
    choose_triangles(mesh, box, triangles.subspan(at->first, at->count), found);
  else
    find_triangles(mesh, box, found, body_on_mesh);
}

}  // namespace tactus::physics
