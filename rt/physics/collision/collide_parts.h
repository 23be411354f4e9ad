// Narrow phase of bodies that may be compounds: which of their parts are near each other, and the manifold of two parts
// with points from the bodies' centres.
//
// Frame: world. Units: m. Thread: [any]; pure, no allocation. Bound: kMaxParts^2 comparisons of boxes; a body of one
// shape is a compound of one part.
#pragma once

#include "rt/base/bounded_vector.h"
#include "rt/physics/collision/manifold.h"
#include "rt/physics/shapes/hull_view.h"
#include "rt/physics/shapes/shape_lists.h"

namespace tactus::physics {

// A body's shape and pose, and by how much the boxes of its parts are grown [m].
struct GrownShape {
  PosedShape body;
  double growth;
};

// Calls f(part of a, part of b) for parts whose grown boxes overlap; for two bodies of one shape always, because the
// caller has compared their boxes. In ascending order.
template <class F>
void for_each_near_parts(const GrownShape& a, const GrownShape& b, const ShapeLists& lists, F&& f) noexcept {
  const std::uint32_t count_a = parts_of(a.body.shape, lists.compounds),
                      count_b = parts_of(b.body.shape, lists.compounds);
  if (count_a == 1 && count_b == 1) return f(0u, 0u);
  const auto box_of = [&](const GrownShape& of, std::uint32_t part) noexcept {
    const PosedPart posed = part_of(of.body, part, lists.compounds);
    return bounds_of(posed.shape, posed.pose, of.growth, lists.hulls);
  };
  FixedVector<Aabb, kMaxParts> boxes_b;
  for (std::uint32_t j = 0; j < count_b; ++j) (void)boxes_b.try_push(box_of(b, j));  // fits: kMaxParts at most
  for (std::uint32_t i = 0; i < count_a; ++i) {
    const Aabb box = box_of(a, i);
    for (std::uint32_t j = 0; j < boxes_b.size(); ++j)
      if (box.overlaps(boxes_b[j])) f(i, j);
  }
}

// Turns points from the parts' centres into points from the bodies' centres, and the gap's lever arm likewise.
inline void move_to_bodies(const PosedPart& a, const PosedPart& b, Manifold& manifold) noexcept {
  for (std::uint32_t i = 0; i < manifold.count; ++i) {
    manifold.points[i].from_a += a.from_body;
    manifold.points[i].from_b += b.from_body;
  }
  manifold.lever_arm += larger(norm(a.from_body), norm(b.from_body));
}

// As collide, for one part of each body; points from the bodies' centres.
inline Manifold collide_parts(const PosedPart& a, const PosedPart& b, const ManifoldQuery& query, AxisCache& cache,
                              Hulls hulls) noexcept {
  Manifold manifold = collide(a.posed(), b.posed(), query, cache, hulls);
  move_to_bodies(a, b, manifold);
  return manifold;
}

// Calls f(part of a, part of b, manifold) for all parts of two bodies, neither of them a mesh, that have points within
// the margin.
template <class F>
void for_each_manifold(PosedShape a, PosedShape b, double margin, const ShapeLists& lists, F&& f) noexcept {
  for_each_near_parts({a, 0.5 * margin}, {b, 0.5 * margin}, lists, [&](std::uint32_t i, std::uint32_t j) noexcept {
    AxisCache cache;
    const Manifold manifold = collide_parts(part_of(a, i, lists.compounds), part_of(b, j, lists.compounds),
                                            {.margin = margin}, cache, lists.hulls);
    if (manifold.count > 0) f(i, j, manifold);
  });
}

}  // namespace tactus::physics
