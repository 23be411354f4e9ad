#include "rt/physics/shapes/mesh_query.h"

#include <algorithm>
#include <array>

namespace tactus::physics {
namespace {

// Squared distance of a point from a box [m^2]; 0 inside.
double squared_distance(const Aabb& box, const Vec3d& p) noexcept {
  double sum = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double beyond = larger(larger(box.lower[i] - p[i], p[i] - box.upper[i]), 0.0);
    sum += beyond * beyond;
  }
  return sum;
}

// The nearest triangles so far: when full, a heap with the farthest on top.
class Nearest {
 public:
  bool is_full() const noexcept { return count_ == kMaxBodyTriangles; }
  bool is_beaten_by(double distance, std::uint32_t index) const noexcept {
    return !is_full() || Entry{distance, index} < entries_[0];
  }
  // False if a triangle was left out.
  bool offer(double distance, std::uint32_t index) noexcept {
    if (!is_full()) {
      entries_[count_++] = {distance, index};
      if (is_full()) std::make_heap(entries_.begin(), entries_.end());
      return true;
    }
    if (is_beaten_by(distance, index)) {
      std::pop_heap(entries_.begin(), entries_.end());
      entries_.back() = {distance, index};
      std::push_heap(entries_.begin(), entries_.end());
    }
    return false;
  }
  void list(TriangleList& found) const noexcept {
    found.triangles.clear();
    for (std::uint32_t i = 0; i < count_; ++i) static_cast<void>(found.triangles.try_push(entries_[i].index));
    std::sort(found.triangles.begin(), found.triangles.end());
  }

 private:
  struct Entry {
    double distance;
    std::uint32_t index;
    bool operator<(const Entry& o) const noexcept {
      return distance != o.distance ? distance < o.distance : index < o.index;
    }
  };
  std::uint32_t count_{0};
  std::array<Entry, kMaxBodyTriangles> entries_;
};

// Finds all triangles whose boxes overlap `box`. False if the list is full, or the search exceeds kMaxMeshVisits nodes
// or the stack.
bool find_all(const Mesh& mesh, const Aabb& box, TriangleList& found) noexcept {
  std::array<std::uint32_t, kMaxMeshDepth> stack;
  std::uint32_t waiting = 0, visits = 0;
  stack[waiting++] = 0;
  while (waiting > 0) {
    const std::uint32_t at = stack[--waiting];
    const MeshNode& node = mesh.nodes[at];
    if (!node.box.overlaps(box)) continue;
    if (visits++ >= kMaxMeshVisits || waiting + 2 > kMaxMeshDepth) return false;
    if (node.second != 0) {
      stack[waiting++] = node.second;
      stack[waiting++] = at + 1;
      continue;
    }
    for (std::uint32_t i = node.first; i < node.first + node.count; ++i)
      if (mesh.box_of(mesh.order[i]).overlaps(box) && !found.triangles.try_push(mesh.order[i])) return false;
  }
  std::sort(found.triangles.begin(), found.triangles.end());
  return true;
}

}  // namespace

void find_triangles(const Mesh& mesh, const Aabb& box, TriangleList& found, BodyOnMesh* body) noexcept {
  found.triangles.clear();
  found.left_out = 0;
  if (mesh.nodes.empty() || find_all(mesh, box, found)) return;
  const Vec3d middle = 0.5 * (box.lower + box.upper);
  Nearest nearest;
  std::array<std::uint32_t, kMaxMeshDepth> stack;
  std::uint32_t waiting = 0, visits = 0;
  stack[waiting++] = 0;
  while (waiting > 0) {
    const std::uint32_t at = stack[--waiting];
    const MeshNode& node = mesh.nodes[at];
    if (!node.box.overlaps(box) || (body != nullptr && !body->can_touch(node))) continue;
    if (visits++ >= kMaxMeshVisits || !nearest.is_beaten_by(squared_distance(node.box, middle), 0)) {
      found.left_out += node.count;
      continue;
    }
    if (node.second == 0) {
      for (std::uint32_t i = node.first; i < node.first + node.count; ++i) {
        const Aabb triangle = mesh.box_of(mesh.order[i]);
        if (!triangle.overlaps(box) || (body != nullptr && !body->can_touch(mesh.order[i]))) continue;
        if (!nearest.offer(squared_distance(triangle, middle), mesh.order[i])) ++found.left_out;
      }
      continue;
    }
    // Visits the nearer child first, so that triangles left out are far.
    std::uint32_t near = at + 1, far = node.second;
    if (squared_distance(mesh.nodes[far].box, middle) < squared_distance(mesh.nodes[near].box, middle))
      std::swap(near, far);
    if (waiting + 2 > kMaxMeshDepth) {
      found.left_out += node.count;
      continue;
    }
    stack[waiting++] = far;
    stack[waiting++] = near;
  }
  nearest.list(found);
}

void choose_triangles(const Mesh& mesh, const Aabb& box, std::span<const std::uint32_t> among,
                      TriangleList& found) noexcept {
  found.triangles.clear();
  found.left_out = 0;
  for (const std::uint32_t triangle : among)
    if (mesh.box_of(triangle).overlaps(box) && !found.triangles.try_push(triangle)) ++found.left_out;
}

}  // namespace tactus::physics
