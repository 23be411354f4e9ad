#include <algorithm>

#include "sim/geometry/mesh_builder.h"

namespace tactus::sim {
namespace {

constexpr std::uint32_t kLeaf = 4;

class TreeBuilder {
 public:
  explicit TreeBuilder(MeshParts& mesh) : mesh_(mesh), view_(mesh.view()) {
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      mesh.order.push_back(t);
      const auto& triangle = mesh.triangles[t];
      middle_.push_back((view_.place(triangle, 0) + view_.place(triangle, 1) + view_.place(triangle, 2)) * (1.0 / 3));
    }
  }

  // Adds the node of order[first, first + count) and its children. The recursion's depth is the logarithm of count.
  void add(std::uint32_t first, std::uint32_t count) {
    const auto at = static_cast<std::uint32_t>(mesh_.nodes.size());
    mesh_.nodes.push_back({.box = box_of(first, count),
                           .first = first,
                           .count = count,
                           .second = 0,
                           .inside_patch = patch_inside(first, count)});
    if (count <= kLeaf) return;
    const int axis = longest_side(first, count);
    const auto begin = mesh_.order.begin() + first;
    std::nth_element(begin, begin + count / 2, begin + count, [&](std::uint32_t s, std::uint32_t t) {
      return middle_[s][axis] != middle_[t][axis] ? middle_[s][axis] < middle_[t][axis] : s < t;
    });
    add(first, count / 2);
    mesh_.nodes[at].second = static_cast<std::uint32_t>(mesh_.nodes.size());
    add(first + count / 2, count - count / 2);
  }

 private:
  static void grow(physics::Aabb& box, const Vec3d& lower, const Vec3d& upper) {
    for (int i = 0; i < 3; ++i) {
      box.lower[i] = std::min(box.lower[i], lower[i]);
      box.upper[i] = std::max(box.upper[i], upper[i]);
    }
  }
  physics::Aabb box_of(std::uint32_t first, std::uint32_t count) const {
    auto box = view_.box_of(mesh_.order[first]);
    for (std::uint32_t i = first + 1; i < first + count; ++i) {
      const auto next = view_.box_of(mesh_.order[i]);
      grow(box, next.lower, next.upper);
    }
    return box;
  }
  std::uint32_t patch_inside(std::uint32_t first, std::uint32_t count) const {
    const std::uint32_t patch = mesh_.triangles[mesh_.order[first]].patch;
    for (std::uint32_t i = first; i < first + count; ++i) {
      const auto& triangle = mesh_.triangles[mesh_.order[i]];
      if (triangle.patch != patch || !view_.is_inside_patch(triangle)) return physics::kNoPatch;
    }
    return patch;
  }
  int longest_side(std::uint32_t first, std::uint32_t count) const {
    physics::Aabb box{middle_[mesh_.order[first]], middle_[mesh_.order[first]]};
    for (std::uint32_t i = first + 1; i < first + count; ++i)
      grow(box, middle_[mesh_.order[i]], middle_[mesh_.order[i]]);
    const Vec3d size = box.upper - box.lower;
    return size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  }

  MeshParts& mesh_;
  physics::Mesh view_;  // of the corners and triangles; the tree does not exist yet
  std::vector<Vec3d> middle_;
};

}  // namespace

void build_tree(MeshParts& mesh) {
  mesh.nodes.clear();
  mesh.order.clear();
  if (mesh.triangles.empty()) return;
  TreeBuilder(mesh).add(0, static_cast<std::uint32_t>(mesh.triangles.size()));
}

}  // namespace tactus::sim
