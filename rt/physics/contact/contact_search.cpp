// The searches of a contact table: narrow phase of the pairs whose last result does not hold any more.
#include "rt/physics/collision/collide_boxes.h"
#include "rt/physics/collision/collide_mesh.h"
#include "rt/physics/collision/collide_parts.h"
#include "rt/physics/contact/contact_table.h"

namespace tactus::physics {
namespace {

// Counted instructions: two boxes 3k; hulls of 8, 20 and 64 vertices 5.5k, 10k and 27k; a box on 60 triangles 42k.
constexpr std::uint32_t kVerticesPerComparison = 16, kTrianglesPerComparison = 4;

}  // namespace

std::uint32_t ContactTable::comparisons_in(const Scene& scene, const Search& search) const noexcept {
  const Pair& pair = pairs_[search.pair];
  if (pair.patch.count > 0) return 1 + pair.patch.count / kTrianglesPerComparison;
  const Sides sides = sides_of(scene, pair);
  const Shape &a = sides.shape_a, &b = sides.shape_b;
  const auto vertices = [&](const Shape& shape) {
    return shape.kind == ShapeKind::kHull ? scene.shapes.hulls[shape.index].topology.vertices : 0;
  };
  return 1 + (vertices(a) + vertices(b)) / kVerticesPerComparison;
}

Manifold ContactTable::compare(const Scene& scene, Search& search) const noexcept {
  const Pair& pair = pairs_[search.pair];
  const ShapeLists& shapes = scene.shapes;
  const Sides sides = sides_of(scene, pair);
  const Body &a = sides.a, &b = sides.b;
  const auto with_patch = [&](PosedShape part) noexcept {
    return collide_patch(part,
                         {.mesh = shapes.meshes[b.shape.index],
                          .world_from_mesh = b.motion.pose,
                          .triangles = scene.mesh_triangles.subspan(pair.patch.first, pair.patch.count)},
                         search.query, shapes.hulls);
  };
  const bool is_patch = b.shape.kind == ShapeKind::kMesh;
  if (a.shape.kind != ShapeKind::kCompound && b.shape.kind != ShapeKind::kCompound)
    return is_patch ? with_patch(posed_shape(a))
                    : collide(posed_shape(a), posed_shape(b), search.query, search.axis_cache, shapes.hulls);
  const PosedPart part_a = part_of(posed_shape(a), sides.part_a, shapes.compounds);
  const PosedPart part_b = part_of(posed_shape(b), sides.part_b, shapes.compounds);
  if (!is_patch) return collide_parts(part_a, part_b, search.query, search.axis_cache, shapes.hulls);
  Manifold manifold = with_patch(part_a.posed());
  move_to_bodies(part_a, part_b, manifold);
  return manifold;
}

// As compare, for up to kBoxPairs searches of two boxes; their manifolds go to manifolds_.
void ContactTable::compare_boxes(const Scene& scene, std::span<const std::uint32_t> searches) noexcept {
  const auto query_of = [&](std::size_t k) noexcept -> BoxPairQuery {
    const std::uint32_t index = searches[k < searches.size() ? k : 0];
    Search& search = searches_[index];
    const Pair& pair = pairs_[search.pair];
    const bool with_fixed = pair.key.with_fixed();
    return {.a = posed_shape(scene.bodies[pair.a]),
            .b = posed_shape(with_fixed ? scene.fixed_bodies[pair.b] : scene.bodies[pair.b]),
            .frame_a = scene.frames[pair.a],
            .frame_b = with_fixed ? scene.fixed_frames[pair.b] : scene.frames[pair.b],
            .query = search.query,
            .cache = search.axis_cache,
            .manifold = manifolds_[index]};
  };
  const std::array<BoxPairQuery, kBoxPairs> queries{query_of(0), query_of(1), query_of(2), query_of(3)};
  collide_boxes(std::span(queries).first(searches.size()));
}

// Makes the searches from `first` to before `end`.
void ContactTable::search(const Scene& scene, std::uint32_t first, std::uint32_t end) noexcept {
  FixedVector<std::uint32_t, kBoxPairs> boxes;
  const auto compare_listed = [&]() noexcept {
    if (boxes.size() > 0) compare_boxes(scene, {boxes.begin(), boxes.size()});
    boxes.clear();
  };
  for (std::uint32_t k = first; k < end; ++k) {
    const Pair& pair = pairs_[searches_[k].pair];
    const Shape& b = pair.key.with_fixed() ? scene.fixed_bodies[pair.b].shape : scene.bodies[pair.b].shape;
    if (scene.bodies[pair.a].shape.kind != ShapeKind::kBox || b.kind != ShapeKind::kBox) {
      manifolds_[k] = compare(scene, searches_[k]);
      continue;
    }
    (void)boxes.try_push(k);  // fits: emptied when full
    if (boxes.size() == kBoxPairs) compare_listed();
  }
  compare_listed();
}

}  // namespace tactus::physics
